// The background, four pixels at once.
#import tile

@group(0) @binding(7) var<storage, read_write> picture: array<vec4<u32>>; // of the tile and what it is rounded up by
override workgroup_size: u32;

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    // Nothing in the loop that need not be there: lavapipe would do it again each time.
    let color = vec4(pack4x8unorm(tile.background));
    let n = (u32(tile.extent.x * tile.extent.y) + 3u) / 4u;
    let stride = n_groups.x * workgroup_size;
    for (var index = invocation.x; index < n; index += stride) {
        picture[index] = color;
    }
}
