// Colours over the picture, for stages that go through the pixels of a tile.
#import tile

@group(0) @binding(7) var<storage, read_write> picture: array<u32>; // of the tile, premultiplied
override workgroup_size: u32;
override is_first: bool = false; // nothing is there yet, not even the background

fn n_pixels() -> u32 {
    return u32(tile.extent.x * tile.extent.y);
}

fn pixel_of(index: u32) -> vec2<i32> {
    let width = u32(tile.extent.x);
    return tile.origin + vec2(i32(index % width), i32(index / width));
}

fn premultiplied(color: vec4<f32>, strength: f32) -> vec4<f32> {
    let alpha = color.a * strength;
    return vec4(color.rgb * alpha, alpha);
}

fn ground_at(index: u32) -> vec4<f32> {
    if is_first {
        return tile.background;
    }
    return unpack4x8unorm(picture[index]);
}

fn draw_over(index: u32, color: vec4<f32>) {
    picture[index] = pack4x8unorm(color + ground_at(index) * (1.0 - color.a));
}
