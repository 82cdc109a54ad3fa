// How far off a place of an edge is.
#import clip_segment
#import depth_cue

// At the part t of a segment, from 0 for the picture's nearest point to 1 for its farthest.
fn farness_at(line: Segment, t: f32) -> f32 {
    let depth = mix(line.depth.x, line.depth.y, t);
    let w = 1.0 / mix(line.inverse_w.x, line.inverse_w.y, t);
    return farness(style.cue, depth, w);
}
