// A segment as it is walked: along the axis that it advances most on, pixel by pixel.
#import clip_segment

struct Walk {
    start: vec2<f32>, // x along, y across
    run: f32, // >= 0
    slope: f32, // -1 to 1
    is_steep: bool, // the picture's y is what is walked along
    is_backward: bool, // from q to p
}

fn walk(line: Segment) -> Walk {
    let is_steep = abs(line.q.y - line.p.y) > abs(line.q.x - line.p.x);
    let p = select(line.p, line.p.yx, is_steep);
    let q = select(line.q, line.q.yx, is_steep);
    let is_backward = q.x < p.x;
    let start = select(p, q, is_backward);
    let run = abs(q.x - p.x);
    let slope = select(0.0, (q.y - p.y) / (q.x - p.x), run > 0.0);
    return Walk(start, run, slope, is_steep, is_backward);
}

// The part of the segment, from p to q, nearest to the middle of the step `x`.
fn part_at(way: Walk, x: i32) -> f32 {
    let t = select(0.0, clamp((f32(x) + 0.5 - way.start.x) / way.run, 0.0, 1.0), way.run > 0.0);
    return select(t, 1.0 - t, way.is_backward);
}

// The part of the segment, from p to q, nearest to the middle of a pixel.
fn foot(line: Segment, pixel: vec2<i32>) -> f32 {
    let span = line.q - line.p;
    let square = dot(span, span);
    return select(0.0, clamp(dot(vec2<f32>(pixel) + 0.5 - line.p, span) / square, 0.0, 1.0), square > 0.0);
}

// What of the tile the walk goes through: the first and the last step along, the first and the last across.
fn bounds_in_tile(way: Walk) -> vec4<i32> {
    let first = select(tile.origin, tile.origin.yx, way.is_steep);
    let last = first + select(tile.extent, tile.extent.yx, way.is_steep) - 1;
    return vec4(first.x, last.x, first.y, last.y);
}

fn pixel_at(way: Walk, x: i32, y: i32) -> vec2<i32> {
    return select(vec2(x, y), vec2(y, x), way.is_steep);
}
