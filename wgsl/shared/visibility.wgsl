// What a face leaves in a pixel: its colour's place, from 1, and, where distance pales faces, how much of it is left.
override is_cued: bool;

const LEFT_STEPS = 255.0;
const LEFT_BITS = 8u;

fn mark_of(place: u32, left: f32) -> u32 {
    return select(place, (place << LEFT_BITS) | u32(left * LEFT_STEPS + 0.5), is_cued);
}

fn place_of(mark: u32) -> u32 {
    return select(mark, mark >> LEFT_BITS, is_cued);
}

fn left_of(mark: u32) -> f32 {
    return select(1.0, f32(mark & ((1u << LEFT_BITS) - 1u)) / LEFT_STEPS, is_cued);
}
