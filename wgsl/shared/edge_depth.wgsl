// The depth of a point of an edge.
#import clip_segment
#import depth_cue

// At the part t of a segment: 0 for the nearest point of the picture, 1 for its farthest.
fn normalized_depth_at(line: Segment, t: f32, cue: DepthCue) -> f32 {
    let depth = mix(line.depth.x, line.depth.y, t);
    let w = 1.0 / mix(line.inverse_w.x, line.inverse_w.y, t);
    return normalized_depth(cue, depth, w);
}
