// Fills the target with the background, four pixels per store.
#import tile

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<storage, read_write> render_target: array<vec4<u32>>; // of the tile, and what rounds it up

override workgroup_size: u32;

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    // Nothing in the loop that need not be there: lavapipe would do it again each time.
    let color = vec4(pack4x8unorm(tile.background));
    let n = (n_pixels(tile) + 3u) / 4u;
    let stride = n_workgroups.x * workgroup_size;
    for (var index = invocation.x; index < n; index += stride) {
        render_target[index] = color;
    }
}
