// Lines that were drawn apart, over the picture.
#import each_mark

override row_step: u32; // pixels at whose multiples rows begin that are copied out of a texture; 1 where they are whole

@group(0) @binding(5) var<storage, read> lines: array<u32>; // premultiplied

fn place_of(index: u32) -> u32 {
    if row_step == 1u {
        return index; // a division takes a CPU longer than all the rest
    }
    let width = u32(tile.extent.x);
    return index / width * ((width + row_step - 1u) / row_step * row_step) + index % width;
}

fn is_marked(index: u32) -> bool {
    return lines[place_of(index)] != 0u;
}

fn color_at_mark(index: u32) -> vec4<f32> {
    return unpack4x8unorm(lines[place_of(index)]);
}
