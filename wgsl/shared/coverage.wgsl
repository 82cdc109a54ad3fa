// How much of a pixel lies under a line: the pixel is a unit square, the line a capsule.

const N_COLUMNS = 4u;

// The part of the unit square around `pixel` under the capsule from `a` to `b`, within a twenty-fifth everywhere and a
// hundredth beside the line. The square is cut into columns, most nearly across the line; the capsule's rim cuts off their
// heights, which are summed.
fn capsule_coverage(pixel: vec2<f32>, a: vec2<f32>, b: vec2<f32>, half_width: f32) -> f32 {
    // Mirrored so that the line runs to the right, at most 45 degrees up or down.
    let steep = abs(b.y - a.y) > abs(b.x - a.x);
    let along = select(b - a, b.yx - a.yx, steep);
    let mirror = vec2(select(1.0, -1.0, along.x < 0.0), 1.0);
    let center = select(pixel - a, pixel.yx - a.yx, steep) * mirror;
    let run = along.x * mirror.x;
    let slope = select(0.0, along.y / run, run > 0.0);

    // Straight outwards from the line, the rim lies this far to the left above, to the right below.
    let lean = vec2(1.0, -1.0) * half_width * slope * inverseSqrt(1.0 + slope * slope);
    let first = max(center.x - 0.5, -half_width);
    let last = min(center.x + 0.5, run + half_width);
    let width = max(last - first, 0.0) / f32(N_COLUMNS);
    var height = 0.0;
    for (var i = 0u; i < N_COLUMNS; i++) {
        let x = first + (f32(i) + 0.5) * width;
        // The points of the line whose circles touch the rim above x and below it.
        let foot = clamp(x + lean, vec2(0.0), vec2(run));
        let across = x - foot;
        let rise = sqrt(max(half_width * half_width - across * across, vec2(0.0)));
        let top = foot.x * slope + rise.x;
        let bottom = foot.y * slope - rise.y;
        height += max(min(top, center.y + 0.5) - max(bottom, center.y - 0.5), 0.0);
    }
    return height * width;
}
