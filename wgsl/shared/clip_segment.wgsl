// An edge clipped to the view volume: a segment of the picture.
#import tile

const NO_POINT = 0xffffffffu; // both ends of an edge that is not there

struct Segment {
    p: vec2<f32>, // pixels
    q: vec2<f32>,
    depth: vec2<f32>, // at p and q
    inverse_w: vec2<f32>, // at p and q
    t_clip: vec2<f32>, // of the edge in clip space, at p and q
    dash_start: f32, // of the edge, as dash_start.wgsl says; whoever asks for dashes sets it
    is_valid: bool,
}

// By bits: WGSL lets a compiler take it for granted that no number is infinite or NaN.
fn is_finite(x: vec4<f32>) -> bool {
    return all((bitcast<vec4<u32>>(x) & vec4(0x7f800000u)) != vec4(0x7f800000u));
}

// The part of `range` for which a coordinate that goes from `at_a` to `at_b` is not negative.
fn clip_range(range: vec2<f32>, at_a: f32, at_b: f32) -> vec2<f32> {
    if at_a < 0.0 && at_b < 0.0 {
        return vec2(1.0, 0.0);
    }
    let t = at_a / (at_a - at_b);
    if at_a < 0.0 {
        return vec2(max(range.x, t), range.y);
    }
    if at_b < 0.0 {
        return vec2(range.x, min(range.y, t));
    }
    return range;
}

// Whether a point in clip space lies in the view volume.
fn is_in_view(a: vec4<f32>) -> bool {
    return a.z > 0.0 && a.z < a.w && abs(a.x) < a.w && abs(a.y) < a.w;
}

// The segment from a to b, both in clip space, in a picture of `size` pixels with a margin for the width of the line.
fn clip_segment(a: vec4<f32>, b: vec4<f32>, margin_px: f32, size: vec2<f32>) -> Segment {
    // At the near and the far plane, so that nothing folds through the eye, and at the picture's sides, so that
    // distances stay small enough for single precision. The sides let no negative w pass.
    let side = 1.0 + 4.0 * margin_px / size;
    var range = clip_range(vec2(0.0, 1.0), a.z, b.z);
    range = clip_range(range, a.w - a.z, b.w - b.z);
    range = clip_range(range, side.x * a.w - a.x, side.x * b.w - b.x);
    range = clip_range(range, side.x * a.w + a.x, side.x * b.w + b.x);
    range = clip_range(range, side.y * a.w - a.y, side.y * b.w - b.y);
    range = clip_range(range, side.y * a.w + a.y, side.y * b.w + b.y);
    let start = mix(a, b, range.x);
    let end = select(mix(a, b, range.y), b, range.y == 1.0); // b itself: a driver may miss it by a bit
    var segment: Segment;
    if range.x > range.y || start.w <= 0.0 || end.w <= 0.0 {
        return segment;
    }
    segment.p = clip_to_pixels(start, size);
    segment.q = clip_to_pixels(end, size);
    segment.inverse_w = 1.0 / vec2(start.w, end.w);
    segment.depth = vec2(start.z, end.z) * segment.inverse_w;
    segment.t_clip = range;
    // Not if a point is not finite: its ends could be any whole numbers.
    segment.is_valid = is_finite(vec4(segment.p, segment.q));
    return segment;
}

// The part of the edge in clip space at the part t of its segment: even steps in the picture are not even along the
// edge, because nearer parts look longer.
fn t_clip_at(line: Segment, t: f32) -> f32 {
    let weights = vec2(1.0 - t, t) * line.inverse_w;
    return mix(line.t_clip.x, line.t_clip.y, weights.y / (weights.x + weights.y));
}
