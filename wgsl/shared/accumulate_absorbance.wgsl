// Ink of many edges, added up in the pixels of a tile.
#import absorbance

@group(0) @binding(5) var<storage, read_write> ink: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read_write> inked: array<atomic<u32>>; // how many pixels have ink, and which
override is_listed: bool; // they are few: what comes next goes through this list, not through all pixels
override may_overflow: bool; // there are so many lines that all through one pixel could be more than it holds

const OVERFULL_INK = 0x80000000u; // far from the largest number, as others add at the same time

fn lay_ink(place: u32, alpha: f32) {
    let amount = ink_of(alpha);
    let before = atomicAdd(&ink[place], amount);
    if is_listed && before == 0u && amount > 0u {
        atomicStore(&inked[1u + atomicAdd(&inked[0], 1u)], place);
    }
    if may_overflow && before > OVERFULL_INK {
        atomicStore(&ink[place], opaque_ink());
    }
}
