// Each pixel that is marked.
#import pixel_loop

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    scan(invocation.x, n_groups.x * workgroup_size);
}
