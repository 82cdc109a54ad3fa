// The depth of a point of an edge.
#import clip_segment
#import dda
#import depth_cue

// At the part t of a segment: 0 for the nearest point of the picture, 1 for its farthest.
fn normalized_depth_at(line: Segment, t: f32, cue: DepthCue) -> f32 {
    let depth = mix(line.depth.x, line.depth.y, t);
    let w = 1.0 / mix(line.inverse_w.x, line.inverse_w.y, t);
    return normalized_depth(cue, depth, w);
}

// The depth of the point nearest to the centre of a pixel, to the last bit the same for all edges between two places,
// whichever way they go: of such edges the last one is on top everywhere, on every adapter.
fn ordering_depth_at(line: Segment, pixel: vec2<i32>, cue: DepthCue) -> f32 {
    let is_reversed = line.q.x < line.p.x || (line.q.x == line.p.x && line.q.y < line.p.y);
    var sorted = line;
    sorted.p = select(line.p, line.q, is_reversed);
    sorted.q = select(line.q, line.p, is_reversed);
    sorted.depth = select(line.depth, line.depth.yx, is_reversed);
    sorted.inverse_w = select(line.inverse_w, line.inverse_w.yx, is_reversed);
    return normalized_depth_at(sorted, t_at_pixel(sorted, pixel), cue);
}
