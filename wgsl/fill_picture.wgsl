// The background.
#import over

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    // Nothing in the loop that need not be there: lavapipe would do it again each time.
    let color = pack4x8unorm(tile.background);
    let n = n_pixels();
    let stride = n_groups.x * workgroup_size;
    for (var index = invocation.x; index < n; index += stride) {
        picture[index] = color;
    }
}
