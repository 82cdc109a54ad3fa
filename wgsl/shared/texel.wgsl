// Arrays as textures, row by row: lavapipe reads texels in a third of the time that it takes for elements of a buffer.
const TEXELS_PER_ROW = 2048u;

fn texel(index: u32) -> vec2<u32> {
    return vec2(index % TEXELS_PER_ROW, index / TEXELS_PER_ROW);
}

// Of the two texels of a point: its position, with one over the mass, 0 for pins.
fn position_texel(point: u32) -> vec2<u32> {
    return texel(2u * point);
}

// And its velocity, with the steps of the frame.
fn velocity_texel(point: u32) -> vec2<u32> {
    return texel(2u * point + 1u);
}
