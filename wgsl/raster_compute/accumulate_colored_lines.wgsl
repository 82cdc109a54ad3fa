// Anti-aliased lines of several colours: ink, which says how much shines through all, and the nearest edges of each pixel,
// which say in what colours it does.
#import line_coverage_loop
#import accumulate_absorbance
#import colors
#import depth_key

@group(0) @binding(8) var<storage, read_write> nearest: array<atomic<u32>>; // n_keys a pixel, the nearest first
override n_keys: u32; // 2 or 4
override is_clear: bool; // something shines through some of the colours

fn opacity_at(index: u32, line: Segment, t: f32) -> f32 {
    if !is_clear {
        return 1.0;
    }
    return color_at(index, line, t).a;
}

// In whatever order keys come: of those that come to a slot, all but the largest go on from it.
fn put(slot: u32, key: u32) -> u32 {
    if key == 0u {
        return 0u;
    }
    return min(key, atomicMax(&nearest[slot], key));
}

fn take(place: u32, alpha: f32, edge: u32, line: Segment, t: f32) {
    lay_ink(place, alpha);
    let slots = n_keys * place;
    let third = put(slots + 1u, put(slots, key_at(line, t, edge))); // no loop: a driver ends long ones
    if n_keys == 4u {
        put(slots + 3u, put(slots + 2u, third));
    }
}
