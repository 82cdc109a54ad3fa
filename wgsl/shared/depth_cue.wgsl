// A depth cue: opacity that is lost to distance.
struct DepthCue {
    depth_scale: f32,
    distance_scale: f32,
    offset: f32,
    amount: f32, // of opacity, lost by the farthest point of the picture
}

// How far off depth d at distance w is: 0 for the nearest point of the picture, 1 for its farthest.
fn normalized_depth(cue: DepthCue, depth: f32, w: f32) -> f32 {
    return clamp(cue.depth_scale * depth + cue.distance_scale * w + cue.offset, 0.0, 1.0);
}
