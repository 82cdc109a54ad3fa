// Narrow anti-aliased lines of one colour, an edge an invocation. Where lines of one colour overlap, their order does not
// matter: what shines through all is the product of what shines through each, so logarithms are summed.
#import coverage
#import strength
#import ink

@group(0) @binding(5) var<storage, read_write> ink: array<atomic<u32>>;
override may_overflow: bool; // there are so many lines that all through one pixel could be more than it holds
override workgroup_size: u32;

const OVERFULL_INK = 0x80000000u; // far from the largest number, as others add at the same time

fn lay_ink(place: u32, amount: u32) {
    let before = atomicAdd(&ink[place], amount);
    if may_overflow && before > OVERFULL_INK {
        atomicStore(&ink[place], opaque_ink());
    }
}

fn lay(index: u32, instance: u32) {
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
    for (var x = first; x <= last; x++) {
        let strength = style.color.a * strength_at(line, part_at(way, x));
        if strength <= 0.0 {
            continue;
        }
        let strips = strips_at(way, half_width, lean, x);
        let rows = rows_of(strips);
        let highest = min(rows.y, bounds.w);
        for (var y = max(rows.x, bounds.z); y <= highest; y++) {
            let alpha = strength * coverage(strips, y);
            if alpha > 0.0 {
                lay_ink(tile_index(pixel_at(way, x, y)), ink_of(alpha));
            }
        }
    }
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    for (var index = invocation.x; index < style.n_edges; index += n_groups.x * workgroup_size) {
        lay(index, invocation.y);
    }
}
