// Lines that were drawn apart, over the picture.
#import each_mark

@group(0) @binding(5) var lines: texture_2d<f32>; // premultiplied

fn is_marked(index: u32) -> bool {
    return textureLoad(lines, pixel_of(index) - tile.origin, 0).a > 0.0;
}

fn color_at_mark(index: u32) -> vec4<f32> {
    return textureLoad(lines, pixel_of(index) - tile.origin, 0);
}
