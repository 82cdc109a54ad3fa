// How much of a pixel lies under a line: the pixel is a unit square, the line a capsule.

// The part of a unit square on the near side of a straight edge at signed distance `distance` from the square's centre.
// `normal` is the edge's unit normal. Exact: the integral of the trapezoid that the square casts along the normal.
fn half_plane_coverage(distance: f32, normal: vec2<f32>) -> f32 {
    let wide = max(abs(normal.x), abs(normal.y));
    let narrow = min(abs(normal.x), abs(normal.y));
    let outer = 0.5 * (wide + narrow);
    let inner = 0.5 * (wide - narrow);
    let s = abs(distance);
    // Beyond `inner` the trapezoid's flank falls off; a flank narrower than this is an upright edge.
    let into_flank = clamp(s - inner, 0.0, narrow);
    var beyond = min(s, inner) / wide;
    if narrow > 1e-6 {
        beyond += into_flank / wide - into_flank * into_flank / (2.0 * wide * narrow);
    }
    if s >= outer {
        beyond = 0.5;
    }
    return select(0.5 - beyond, 0.5 + beyond, distance >= 0.0);
}

// The part of a unit square around `pixel` that lies between two parallel edges `half_width` either side of a line at
// signed distance `distance`.
fn strip_coverage(distance: f32, half_width: f32, normal: vec2<f32>) -> f32 {
    return half_plane_coverage(half_width - distance, normal) - half_plane_coverage(-half_width - distance, normal);
}

// The part of the unit square around `pixel` under the capsule from `a` to `b`: exact beside the line and along its
// ends, where the round cap takes over by the share of the pixel that lies beyond the end.
fn capsule_coverage(pixel: vec2<f32>, a: vec2<f32>, b: vec2<f32>, half_width: f32) -> f32 {
    let along = b - a;
    let length_px = length(along);
    let tangent = select(vec2(1.0, 0.0), along / length_px, length_px > 0.0);
    let normal = vec2(-tangent.y, tangent.x);
    let from_a = pixel - a;
    let station = dot(from_a, tangent);
    let beside = strip_coverage(abs(dot(from_a, normal)), half_width, normal);
    let inside = half_plane_coverage(station, tangent) + half_plane_coverage(length_px - station, tangent) - 1.0;
    if inside >= 1.0 {
        return beside;
    }
    let from_end = from_a - tangent * clamp(station, 0.0, length_px);
    let distance = length(from_end);
    let outward = select(normal, from_end / distance, distance > 0.0);
    let cap = strip_coverage(distance, half_width, outward);
    return mix(min(cap, beside), beside, max(inside, 0.0));
}
