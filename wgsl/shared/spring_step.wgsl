// One leapfrog step: a kick of the velocities by the accelerations, then a drift of the positions by the velocities.
struct SpringStep {
    gravity: vec3<f32>, // m/s^2
    kick_s: f32,
    wind: vec3<f32>, // m/s
    drift_s: f32,
    n_points: u32,
    is_first: u32, // of its frame
    frame_part: f32, // of a frame, that a step takes
    damping_s: f32, // of each spring, over its stiffness
    face_drag: f32, // kg/m^3: a sixth of the drag coefficient times half the density of air
    drag_rate: f32, // 1/s
}
