// Goes through the pixels that lines cover, each edge in one or several lanes, and has `take` told of each.
#import coverage
#import line_opacity

override workgroup_size: u32;

fn go_along(index: u32, instance: u32, lane: u32) {
    let half_width = 0.5 * style.line_width;
    let line = segment(edges[index], instance, half_width + 1.0);
    if !line.exists {
        return;
    }
    let way = walk(line);
    let lean = rim_lean(way, half_width);
    let bounds = bounds_in_tile(way);
    let first = max(i32(floor(way.start.x - half_width)), bounds.x);
    let last = min(i32(floor(way.start.x + way.run + half_width)), bounds.y);
    for (var x = first + i32(lane); x <= last; x += 1 << style.log2_lanes) {
        var strength = 0.0;
        if !is_wide {
            let t = part_at(way, x);
            strength = opacity_at(index, line, t) * strength_at(line, t);
            if hidden != HIDDEN_SHOW && strength <= 0.0 {
                continue;
            }
        }
        let strips = strips_at(way, half_width, lean, x);
        let rows = rows_of(strips);
        let highest = min(rows.y, bounds.w);
        for (var y = max(rows.x, bounds.z); y <= highest; y++) {
            let pixel = pixel_at(way, x, y);
            let t = foot(line, pixel);
            if is_wide {
                strength = opacity_at(index, line, t) * strength_at(line, t);
            }
            let alpha = strength * coverage(strips, y);
            if alpha > 0.0 {
                take(tile_index(pixel), alpha, instance * style.n_edges + index, line, t);
            }
        }
    }
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let n = style.n_edges << style.log2_lanes;
    for (var i = invocation.x; i < n; i += n_groups.x * workgroup_size) {
        go_along(i >> style.log2_lanes, invocation.y, i & ((1u << style.log2_lanes) - 1u));
    }
}
