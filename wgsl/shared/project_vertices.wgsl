// Every vertex to clip space, once a frame: four packed points an invocation. Clip space is single precision always.
#import homogeneous

@group(0) @binding(1) var<storage, read> source: array<Vec4>;
@group(0) @binding(2) var<storage, read_write> destination: array<vec4<f32>>;

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= n_quads() {
        return;
    }
    let m = transforms[0].target_from_source;
    let i = invocation.x;
    let a = source[3u * i];
    let b = source[3u * i + 1u];
    let c = source[3u * i + 2u];
    destination[4u * i] = vec4<f32>(m[0] * a.x + m[1] * a.y + m[2] * a.z + m[3]);
    destination[4u * i + 1u] = vec4<f32>(m[0] * a.w + m[1] * b.x + m[2] * b.y + m[3]);
    destination[4u * i + 2u] = vec4<f32>(m[0] * b.z + m[1] * b.w + m[2] * c.x + m[3]);
    destination[4u * i + 3u] = vec4<f32>(m[0] * c.y + m[1] * c.z + m[2] * c.w + m[3]);
}
