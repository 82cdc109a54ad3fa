// Coverage: how much of a pixel lies under a line. The pixel is a unit square, the line a capsule.
#import dda

// Straight outwards from the line, the capsule's edge lies this far to the left above, to the right below.
fn edge_offset(axis: MajorAxis, half_width: f32) -> f32 {
    return half_width * axis.slope * inverseSqrt(1.0 + axis.slope * axis.slope);
}

// A column, cut into four strips most nearly across the line, and where the capsule's edge cuts them off.
struct ColumnSpans {
    bottom: vec4<f32>, // across
    top: vec4<f32>,
    width: f32, // of each strip; 0 if the capsule has ended
}

fn column_spans(axis: MajorAxis, half_width: f32, offset: f32, x: i32) -> ColumnSpans {
    let left = f32(x) - axis.start.x;
    let first = max(left, -half_width);
    let last = min(left + 1.0, axis.length_major + half_width);
    let width = 0.25 * max(last - first, 0.0);
    let at = first + width * vec4(0.5, 1.5, 2.5, 3.5);
    // The points of the line whose circles touch the edge above and below `at`.
    let center_above = clamp(at + offset, vec4(0.0), vec4(axis.length_major));
    let center_below = clamp(at - offset, vec4(0.0), vec4(axis.length_major));
    let top = axis.start.y + axis.slope * center_above + circle_height(half_width, at - center_above);
    let bottom = axis.start.y + axis.slope * center_below - circle_height(half_width, at - center_below);
    return ColumnSpans(bottom, top, width);
}

// How high a circle's edge lies over the height of its centre, at some distance from the centre.
fn circle_height(radius: f32, distance: vec4<f32>) -> vec4<f32> {
    return sqrt(max(radius * radius - distance * distance, vec4(0.0)));
}

// The first and the last pixel of a column that the capsule touches.
fn row_range(spans: ColumnSpans) -> vec2<i32> {
    let bottom = min(spans.bottom.xy, spans.bottom.zw);
    let top = max(spans.top.xy, spans.top.zw);
    return vec2(i32(floor(min(bottom.x, bottom.y))), i32(floor(max(top.x, top.y))));
}

// The part of the pixel `y` of a column under the capsule: within 1/25 everywhere, and 1/100 beside the line.
fn coverage(spans: ColumnSpans, y: i32) -> f32 {
    let row = vec4(f32(y));
    let heights = max(min(spans.top, row + 1.0) - max(spans.bottom, row), vec4(0.0));
    return spans.width * (heights.x + heights.y + heights.z + heights.w);
}

// The part of a pixel under the capsule around a segment.
fn pixel_coverage(axis: MajorAxis, half_width: f32, pixel: vec2<i32>) -> f32 {
    let step = select(pixel, pixel.yx, axis.is_steep);
    return coverage(column_spans(axis, half_width, edge_offset(axis, half_width), step.x), step.y);
}
