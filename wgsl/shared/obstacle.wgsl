// Obstacles: half spaces, and boxes with rounded edges, of which spheres and capsules are special cases.
// Entry declares: obstacles.
const MAX_OBSTACLES = 32u;

struct Obstacle {
    rotation_before: vec4<f32>, // unit quaternions (x, y, z, w), from the obstacle's frame: when the frame begins
    rotation_after: vec4<f32>, // and when it ends
    center_before: vec3<f32>,
    friction: f32,
    center_after: vec3<f32>,
    gap: f32, // that points keep from the surface
    half_size: vec3<f32>, // of the box, without what is rounded
    radius: f32, // of what is rounded
    velocity: vec3<f32>, // of the centre
    is_half_space: u32, // y <= 0 in its own frame
    angular_velocity: vec3<f32>,
}

struct Particle {
    position: vec3<f32>,
    velocity: vec3<f32>,
}

fn rotate_by(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    let t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}

// The outer normal at the surface point closest to p, and the signed distance to it, in the obstacle's frame.
fn surface_distance(half_size: vec3<f32>, radius: f32, p: vec3<f32>) -> vec4<f32> {
    let d = abs(p) - half_size;
    let signs = select(vec3(-1.0), vec3(1.0), p >= vec3());
    let beyond = max(d, vec3());
    let square = dot(beyond, beyond);
    if square > 0.0 {
        let inverse_length = inverseSqrt(square);
        return vec4(signs * beyond * inverse_length, square * inverse_length - radius);
    }
    if d.x >= d.y && d.x >= d.z {
        return vec4(signs.x, 0.0, 0.0, d.x - radius);
    }
    if d.y >= d.z {
        return vec4(0.0, signs.y, 0.0, d.y - radius);
    }
    return vec4(0.0, 0.0, signs.z, d.z - radius);
}

// Push a particle out of an obstacle, take the approaching part of its velocity, and of the sliding part what Coulomb's
// law lets friction take for it. What friction takes has not moved it either, in the drift before.
fn collide(k: u32, time: f32, drift_s: f32, particle: Particle) -> Particle {
    let center = mix(obstacles[k].center_before, obstacles[k].center_after, time);
    let q = normalize(mix(obstacles[k].rotation_before, obstacles[k].rotation_after, time));
    let arm = particle.position - center;
    let local = rotate_by(vec4(-q.xyz, q.w), arm);
    let of_box = surface_distance(obstacles[k].half_size, obstacles[k].radius, local);
    // Not an `if`: see `n_obstacles`.
    let surface = select(of_box, vec4(0.0, 1.0, 0.0, local.y), obstacles[k].is_half_space != 0u);
    if surface.w >= obstacles[k].gap {
        return particle;
    }
    let normal = rotate_by(q, surface.xyz);
    let carried = obstacles[k].velocity + cross(obstacles[k].angular_velocity, arm);
    let relative = particle.velocity - carried;
    let approach = dot(relative, normal);
    let sliding = relative - approach * normal;
    let speed = length(sliding);
    var lost = vec3<f32>();
    if approach < 0.0 && speed > 0.0 {
        lost = min(1.0, -obstacles[k].friction * approach / speed) * sliding;
    }
    return Particle(
        particle.position + (obstacles[k].gap - surface.w) * normal - drift_s * lost,
        particle.velocity - min(approach, 0.0) * normal - lost,
    );
}
