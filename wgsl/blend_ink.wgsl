// Ink in the style's colour over the picture.
#import edge
#import ink
#import each_mark

@group(0) @binding(5) var<storage, read> ink: array<u32>;

fn is_marked(index: u32) -> bool {
    return ink[index] != 0u;
}

fn color_at_mark(index: u32) -> vec4<f32> {
    return premultiplied(vec4(style.color.rgb, 1.0), alpha_of(ink[index]));
}
