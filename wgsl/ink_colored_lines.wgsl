// Anti-aliased lines of several colours: ink, which says how much shines through all, and the two nearest edges of each
// pixel, which say in what colour it does.
#import each_covered
#import lay_ink
#import colors
#import nearness

@group(0) @binding(8) var<storage, read_write> nearest: array<atomic<u32>>; // two keys a pixel, the nearer first
override is_clear: bool; // something shines through some of the colours

fn opacity_at(index: u32, line: Segment, t: f32) -> f32 {
    if !is_clear {
        return 1.0;
    }
    return color_at(index, line, t).a;
}

fn take(place: u32, alpha: f32, edge: u32, line: Segment, t: f32) {
    lay_ink(place, alpha);
    let key = key_at(line, t, edge);
    // Whichever comes first: every key but the largest is at some time the lesser of two.
    let lesser = min(key, atomicMax(&nearest[2u * place], key));
    if lesser > 0u {
        atomicMax(&nearest[2u * place + 1u], lesser);
    }
}
