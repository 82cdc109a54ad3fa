// How far off depth d at distance w is: 0 for the picture's nearest point, 1 for its farthest.
fn farness(cue: vec4<f32>, depth: f32, w: f32) -> f32 {
    return clamp(cue.x * depth + cue.y * w + cue.z, 0.0, 1.0);
}
