// What distance leaves of a strength, from 0 to 1, at depth d and distance w: 1 - cue.w * clamp(x * d + y * w + z, 0, 1).
fn left_by_distance(cue: vec4<f32>, depth: f32, w: f32) -> f32 {
    return 1.0 - cue.w * clamp(cue.x * depth + cue.y * w + cue.z, 0.0, 1.0);
}
