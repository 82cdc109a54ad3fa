// Visibility: what a face leaves in a pixel of the visibility buffer. It is an id, counted from 1, or, if a depth cue
// fades the faces, a colour's index, counted from 1, beside the opacity that the cue leaves.
const OPACITY_STEPS = 255.0;
const OPACITY_BITS = 8u;

fn pack_visibility(color_id: u32, opacity: f32) -> u32 {
    return (color_id << OPACITY_BITS) | u32(opacity * OPACITY_STEPS + 0.5);
}

fn unpack_color_id(visibility: u32) -> u32 {
    return visibility >> OPACITY_BITS;
}

fn unpack_opacity(visibility: u32) -> f32 {
    return f32(visibility & ((1u << OPACITY_BITS) - 1u)) / OPACITY_STEPS;
}
