// How much of a pixel lies under a line: the pixel is a unit square, the line a capsule.
#import across

const N_COLUMNS = 4u;

// Straight outwards from the line, its rim lies this far to the left above, to the right below.
fn rim_lean(way: Walk, half_width: f32) -> f32 {
    return half_width * way.slope * inverseSqrt(1.0 + way.slope * way.slope);
}

// The part of the unit square around `middle`, counted from the start of the walk, under the capsule around it: within a
// twenty-fifth everywhere and a hundredth beside the line. The square is cut into columns, most nearly across the line;
// the capsule's rim cuts off their heights, which are summed.
fn capsule_coverage(way: Walk, half_width: f32, lean: f32, middle: vec2<f32>) -> f32 {
    let first = max(middle.x - 0.5, -half_width);
    let last = min(middle.x + 0.5, way.run + half_width);
    let width = max(last - first, 0.0) / f32(N_COLUMNS);
    var height = 0.0;
    for (var i = 0u; i < N_COLUMNS; i++) {
        let x = first + (f32(i) + 0.5) * width;
        // The points of the line whose circles touch the rim above x and below it.
        let foot = clamp(vec2(x + lean, x - lean), vec2(0.0), vec2(way.run));
        let across = x - foot;
        let rise = sqrt(max(half_width * half_width - across * across, vec2(0.0)));
        let top = foot.x * way.slope + rise.x;
        let bottom = foot.y * way.slope - rise.y;
        height += max(min(top, middle.y + 0.5) - max(bottom, middle.y - 0.5), 0.0);
    }
    return height * width;
}
