// Edges to anti-aliased lines of any width: a quad around each, its pixels lit by how much of them the line covers.
#import coverage
#import picture

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) ends: vec4<f32>, // pixels
    @location(1) @interpolate(flat) color: vec4<f32>, // straight alpha
}

const PIXEL_RADIUS = 0.7072; // of a pixel's circumscribed circle

// The part [t0, t1] of the segment from `a` to `b` for which a coordinate that goes from `at_a` to `at_b` is not negative.
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

fn to_pixels(clip: vec4<f32>) -> vec2<f32> {
    return (clip.xy / clip.w * vec2(0.5, -0.5) + 0.5) * picture.size;
}

@vertex
fn vs_main(@builtin(vertex_index) corner: u32, @builtin(instance_index) index: u32) -> Corner {
    let edge = edges[index];
    let a = projected[edge.x];
    let b = projected[edge.y];
    let reach = 0.5 * picture.line_width + PIXEL_RADIUS;

    // Cut at the near and the far plane, so that nothing folds through the eye, and at the picture's sides with room for
    // the line's width, so that the distances below stay small enough for single precision. The sides let no negative w
    // pass.
    let side = 1.0 + 4.0 * reach / picture.size;
    var range = clipped(vec2(0.0, 1.0), a.z, b.z);
    range = clipped(range, a.w - a.z, b.w - b.z);
    range = clipped(range, side.x * a.w - a.x, side.x * b.w - b.x);
    range = clipped(range, side.x * a.w + a.x, side.x * b.w + b.x);
    range = clipped(range, side.y * a.w - a.y, side.y * b.w - b.y);
    range = clipped(range, side.y * a.w + a.y, side.y * b.w + b.y);
    let start = mix(a, b, range.x);
    let end = mix(a, b, range.y);

    var out: Corner;
    if range.x > range.y || start.w <= 0.0 || end.w <= 0.0 {
        out.position = vec4(2.0, 2.0, 0.0, 1.0); // all four corners in one place, outside: no pixel
        return out;
    }
    let p = to_pixels(start);
    let q = to_pixels(end);
    let length_px = distance(p, q);
    let tangent = select(vec2(1.0, 0.0), (q - p) / length_px, length_px > 0.0);
    let normal = vec2(-tangent.y, tangent.x);
    let at_end = (corner & 1u) == 1u;
    let above = (corner & 2u) == 2u;
    let base = select(p - tangent * reach, q + tangent * reach, at_end);
    let pixel = base + normal * select(-reach, reach, above);
    out.position = vec4((pixel / picture.size - 0.5) * vec2(2.0, -2.0), 0.0, 1.0);
    out.ends = vec4(p, q);
    out.color = edge_color(index);
    return out;
}

@fragment
fn fs_main(in: Corner) -> @location(0) vec4<f32> {
    let coverage = capsule_coverage(in.position.xy, in.ends.xy, in.ends.zw, 0.5 * picture.line_width);
    if coverage <= 0.0 {
        discard;
    }
    let alpha = in.color.a * coverage;
    return vec4(in.color.rgb * alpha, alpha); // premultiplied, as the blending expects
}
