// Every vertex of every instance to clip space, once per picture: a packet of four points per invocation, through the
// instance's own matrix. Clip space is always single precision.
#import real

struct VertexTransform {
    n_packets: u32, // of each instance, the last one padded
}

@group(0) @binding(0) var<uniform> vertex_transform: VertexTransform;
@group(0) @binding(1) var<storage, read> matrices: array<Mat4>; // one per instance
@group(0) @binding(2) var<storage, read> points: array<Vec4>;
@group(0) @binding(3) var<storage, read_write> clip_positions: array<vec4<f32>>;

override workgroup_size: u32;

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= vertex_transform.n_packets {
        return;
    }
    let m = matrices[invocation.y];
    let i = 3u * invocation.x;
    let j = 4u * (invocation.y * vertex_transform.n_packets + invocation.x);
    let a = points[i];
    let b = points[i + 1u];
    let c = points[i + 2u];
    clip_positions[j] = vec4<f32>(m[0] * a.x + m[1] * a.y + m[2] * a.z + m[3]);
    clip_positions[j + 1u] = vec4<f32>(m[0] * a.w + m[1] * b.x + m[2] * b.y + m[3]);
    clip_positions[j + 2u] = vec4<f32>(m[0] * b.z + m[1] * b.w + m[2] * c.x + m[3]);
    clip_positions[j + 3u] = vec4<f32>(m[0] * c.y + m[1] * c.z + m[2] * c.w + m[3]);
}
