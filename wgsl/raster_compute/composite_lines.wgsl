// Ink in the style's colour over the picture.
#import clip_segment
#import composite_listed

fn color_at_mark(place: u32) -> vec4<f32> {
    return premultiplied(vec4(style.color.rgb, 1.0), alpha_of(ink[place]));
}
