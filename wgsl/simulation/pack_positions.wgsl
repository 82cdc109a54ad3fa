// The positions of a simulation as packed points, three numbers each, for pictures.
#import texel

@group(0) @binding(0) var state: texture_storage_2d<rgba32float, read>;
@group(0) @binding(1) var<storage, read_write> points: array<f32>;

override workgroup_size: u32;
override n_points: u32;

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let i = invocation.x;
    if i < n_points {
        let position = textureLoad(state, position_texel(i));
        points[3u * i] = position.x;
        points[3u * i + 1u] = position.y;
        points[3u * i + 2u] = position.z;
    }
}
