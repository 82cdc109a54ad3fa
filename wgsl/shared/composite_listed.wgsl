// Each pixel that has ink.
#import absorbance
#import pixel_loop

@group(0) @binding(5) var<storage, read> ink: array<u32>;
@group(0) @binding(9) var<storage, read> inked: array<u32>; // as in accumulate_absorbance.wgsl
override is_listed: bool;

fn is_marked(place: u32) -> bool {
    return ink[place] != 0u;
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let stride = n_groups.x * workgroup_size;
    if !is_listed {
        scan(invocation.x, stride);
        return;
    }
    let n = inked[0];
    for (var i = invocation.x; i < n; i += stride) {
        let place = inked[1u + i];
        draw_over(place, color_at_mark(place));
    }
}
