// Goes through the pixels of a tile that `is_marked` says yes to, and draws `color_at_mark`, premultiplied, over them.
#import over

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let stride = n_groups.x * workgroup_size;
    let n = n_pixels();
    var index = invocation.x;
    loop {
        // Each invocation looks for its next pixel first: on a CPU, what is skipped in step costs as much as what is done.
        while index < n && !is_marked(index) {
            index += stride;
        }
        if index >= n {
            break;
        }
        draw_over(index, color_at_mark(index));
        index += stride;
    }
}
