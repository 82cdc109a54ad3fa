// The background.
#import over

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    for (var index = invocation.x; index < n_pixels(); index += n_groups.x * workgroup_size) {
        picture[index] = pack4x8unorm(tile.background);
    }
}
