// Anti-aliased lines of one colour. Where they overlap, their order does not matter: what shines through all is the product
// of what shines through each.
#import line_coverage_loop
#import accumulate_absorbance

fn opacity_at(_index: u32, _line: Segment, _t: f32) -> f32 {
    return style.color.a;
}

fn take(place: u32, alpha: f32, _edge: u32, _line: Segment, _t: f32) {
    lay_ink(place, alpha);
}
