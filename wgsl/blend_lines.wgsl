// Lines that were drawn apart, over the picture.
#import each_mark

const ROW_STEP = 64u; // pixels: rows that are copied out of a texture begin at multiples of 256 bytes

@group(0) @binding(5) var<storage, read> lines: array<u32>; // premultiplied

fn place_of(index: u32) -> u32 {
    let width = u32(tile.extent.x);
    return index / width * ((width + ROW_STEP - 1u) / ROW_STEP * ROW_STEP) + index % width;
}

fn is_marked(index: u32) -> bool {
    return lines[place_of(index)] != 0u;
}

fn color_at_mark(index: u32) -> vec4<f32> {
    return unpack4x8unorm(lines[place_of(index)]);
}
