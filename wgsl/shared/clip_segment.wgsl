// An edge as a segment of the picture.
#import tile

struct Style {
    cue: vec4<f32>, // what an edge of depth d at distance w loses of its strength: w * clamp(x * d + y * w + z, 0, 1)
    color: vec4<f32>, // of all edges, straight alpha, where they have one
    line_width: f32, // pixels
    strength: f32, // of all edges, from 0 to 1
    n_edges: u32,
    n_points: u32, // of one instance in `projected`, padding included
    edge_bits: u32, // of a key: which edge it is; 8 to 31, so that nearness has no more bits than a float
    log2_lanes: u32, // invocations an edge, each of which takes every so many-th step along it
}

const NO_POINT = 0xffffffffu;

@group(0) @binding(1) var<uniform> style: Style;
@group(0) @binding(2) var<storage, read> projected: array<vec4<f32>>; // clip space, depth 1 at the near plane
@group(0) @binding(3) var<storage, read> edges: array<vec2<u32>>;

struct Segment {
    p: vec2<f32>, // pixels
    q: vec2<f32>,
    depth: vec2<f32>, // at p and q
    inverse_w: vec2<f32>, // at p and q
    part: vec2<f32>, // of the edge, in clip space
    exists: bool,
}

// By bits: WGSL lets a compiler take it for granted that no number is infinite or NaN.
fn is_finite(x: vec4<f32>) -> bool {
    return all((bitcast<vec4<u32>>(x) & vec4(0x7f800000u)) != vec4(0x7f800000u));
}

// The part of `range` for which a coordinate that goes from `at_a` to `at_b` is not negative.
fn clipped(range: vec2<f32>, at_a: f32, at_b: f32) -> vec2<f32> {
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

fn segment(edge: vec2<u32>, instance: u32, reach: f32) -> Segment {
    var out: Segment;
    if edge.x == NO_POINT {
        return out;
    }
    let first = instance * style.n_points;
    let a = projected[first + edge.x];
    let b = projected[first + edge.y];

    // Cut at the near and the far plane, so that nothing folds through the eye, and at the picture's sides with room for
    // the line's width, so that distances stay small enough for single precision. The sides let no negative w pass.
    let side = 1.0 + 4.0 * reach / tile.size;
    var part = clipped(vec2(0.0, 1.0), a.z, b.z);
    part = clipped(part, a.w - a.z, b.w - b.z);
    part = clipped(part, side.x * a.w - a.x, side.x * b.w - b.x);
    part = clipped(part, side.x * a.w + a.x, side.x * b.w + b.x);
    part = clipped(part, side.y * a.w - a.y, side.y * b.w - b.y);
    part = clipped(part, side.y * a.w + a.y, side.y * b.w + b.y);
    let start = mix(a, b, part.x);
    let end = mix(a, b, part.y);
    if part.x > part.y || start.w <= 0.0 || end.w <= 0.0 {
        return out;
    }
    out.p = to_pixels(start);
    out.q = to_pixels(end);
    out.inverse_w = 1.0 / vec2(start.w, end.w);
    out.depth = vec2(start.z, end.z) * out.inverse_w;
    out.part = part;
    // An edge to a point that is none; walked along, its ends could be any whole numbers.
    out.exists = is_finite(vec4(out.p, out.q));
    return out;
}
