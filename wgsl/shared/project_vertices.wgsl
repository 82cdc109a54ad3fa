// Every vertex of every instance to clip space, once a picture: four packed points an invocation, in the instance's own
// matrix. Clip space is single precision always.
struct Projection {
    n_quads: u32, // groups of four points, the last one padded
}

@group(0) @binding(0) var<uniform> projection: Projection;
@group(0) @binding(1) var<storage, read> matrices: array<Mat4>; // one an instance
@group(0) @binding(2) var<storage, read> source: array<Vec4>;
@group(0) @binding(3) var<storage, read_write> destination: array<vec4<f32>>;
override workgroup_size: u32;

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= projection.n_quads {
        return;
    }
    let m = matrices[invocation.y];
    let i = 3u * invocation.x;
    let j = 4u * (invocation.y * projection.n_quads + invocation.x);
    let a = source[i];
    let b = source[i + 1u];
    let c = source[i + 2u];
    destination[j] = vec4<f32>(m[0] * a.x + m[1] * a.y + m[2] * a.z + m[3]);
    destination[j + 1u] = vec4<f32>(m[0] * a.w + m[1] * b.x + m[2] * b.y + m[3]);
    destination[j + 2u] = vec4<f32>(m[0] * b.z + m[1] * b.w + m[2] * c.x + m[3]);
    destination[j + 3u] = vec4<f32>(m[0] * c.y + m[1] * c.z + m[2] * c.w + m[3]);
}
