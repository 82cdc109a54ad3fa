// Lines one pixel wide: each pixel takes the nearest edge through it.
#import dda
#import line_opacity
#import depth_key

@group(0) @binding(5) var<storage, read_write> marks: array<atomic<u32>>;
override workgroup_size: u32;
override is_plain: bool; // all that is drawn looks the same: who drew it is not asked

fn mark_pixels(index: u32, instance: u32) {
    let line = segment(edges[index], instance, 1.0);
    if !line.exists {
        return;
    }
    let way = walk(line);
    let bounds = bounds_in_tile(way);
    // Half open, so that a chain of edges lights each column once; but every edge lights a pixel.
    let begin = i32(ceil(way.start.x - 0.5));
    let before = max(i32(ceil(way.start.x + way.run - 0.5)), begin + 1);
    for (var x = max(begin, bounds.x); x < min(before, bounds.y + 1); x++) {
        let along = clamp(f32(x) + 0.5 - way.start.x, 0.0, way.run);
        let y = i32(floor(way.start.y + way.slope * along));
        if y < bounds.z || y > bounds.w {
            continue;
        }
        let place = tile_index(pixel_at(way, x, y));
        if is_plain && hidden == HIDDEN_SHOW {
            atomicStore(&marks[place], 1u);
            continue;
        }
        let t = part_at(way, x);
        if (hidden == HIDDEN_SHOW && !is_cued) || strength_at(line, t) >= 0.5 / 255.0 {
            atomicMax(&marks[place], key_at(line, t, instance * style.n_edges + index));
        }
    }
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    for (var index = invocation.x; index < style.n_edges; index += n_groups.x * workgroup_size) {
        mark_pixels(index, invocation.y);
    }
}
