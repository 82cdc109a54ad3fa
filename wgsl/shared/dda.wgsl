// A digital differential analyser: a segment stepped through along its major axis, a column of pixels at a time.
// Columns are rows of the picture if the segment is steep.
#import clip_segment
#import tile

struct MajorAxis {
    start: vec2<f32>, // x along the axis, y across it
    length_major: f32, // of the segment along the axis, pixels
    slope: f32, // -1 to 1
    is_steep: bool, // the axis is the picture's y
    is_reversed: bool, // it goes from q to p
}

fn major_axis(line: Segment) -> MajorAxis {
    let is_steep = abs(line.q.y - line.p.y) > abs(line.q.x - line.p.x);
    let p = select(line.p, line.p.yx, is_steep);
    let q = select(line.q, line.q.yx, is_steep);
    let is_reversed = q.x < p.x;
    let start = select(p, q, is_reversed);
    let length_major = abs(q.x - p.x);
    let slope = select(0.0, (q.y - p.y) / (q.x - p.x), length_major > 0.0);
    return MajorAxis(start, length_major, slope, is_steep, is_reversed);
}

// The part of the segment, from p to q, nearest to the centre of the column x.
fn t_at_column(axis: MajorAxis, x: i32) -> f32 {
    let is_long = axis.length_major > 0.0;
    let t = select(0.0, clamp((f32(x) + 0.5 - axis.start.x) / axis.length_major, 0.0, 1.0), is_long);
    return select(t, 1.0 - t, axis.is_reversed);
}

// The part of the segment, from p to q, nearest to the centre of a pixel.
fn t_at_pixel(line: Segment, pixel: vec2<i32>) -> f32 {
    let span = line.q - line.p;
    let square = dot(span, span);
    return select(0.0, clamp(dot(vec2<f32>(pixel) + 0.5 - line.p, span) / square, 0.0, 1.0), square > 0.0);
}

// The part of the segment, from p to q, that says how opaque a pixel is: its own, or that of all its column.
fn t_of_opacity(line: Segment, axis: MajorAxis, pixel: vec2<i32>, is_wide: bool) -> f32 {
    return select(t_at_column(axis, select(pixel.x, pixel.y, axis.is_steep)), t_at_pixel(line, pixel), is_wide);
}

// The columns and rows of the tile: the first and the last along the axis, the first and the last across it.
fn bounds_in_tile(axis: MajorAxis, tile: Tile) -> vec4<i32> {
    let first = select(tile.origin, tile.origin.yx, axis.is_steep);
    let last = first + select(tile.extent, tile.extent.yx, axis.is_steep) - 1;
    return vec4(first.x, last.x, first.y, last.y);
}

fn pixel_at(axis: MajorAxis, x: i32, y: i32) -> vec2<i32> {
    return select(vec2(x, y), vec2(y, x), axis.is_steep);
}
