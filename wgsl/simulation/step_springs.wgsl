// One leapfrog step of points joined by springs: one point per invocation, which gathers the forces of its springs.
#import spring_step
#import obstacle
#import spring_slots
#import texel

@group(0) @binding(0) var<uniform> spring_step: SpringStep;
@group(0) @binding(1) var<uniform> obstacles: array<Obstacle, MAX_OBSTACLES>;
@group(0) @binding(2) var springs: texture_storage_2d<rgba32uint, read>; // a texel or three per packet
@group(0) @binding(3) var<storage, read> fans: array<vec2<u32>>; // other corners of triangles
@group(0) @binding(4) var<storage, read> forces: array<vec4<f32>>; // N, per point
@group(0) @binding(5) var state: texture_storage_2d<rgba32float, read>;
@group(0) @binding(6) var next_state: texture_storage_2d<rgba32float, write>;
@group(0) @binding(7) var<uniform> packets: array<SlotPacket, MAX_PACKETS>;
@group(0) @binding(8) var<storage, read> masks: array<u32>; // a bit per slot that a point uses

override workgroup_size: u32;
override n_packets: u32; // of four slots, per point
override slots: u32; // how springs are found
override n_fans: u32; // triangles per point
override has_damping: bool;
override has_forces: bool;
override n_obstacles: u32; // a constant: lavapipe compiles a shader anew at each dispatch if a uniform bounds a loop

const TINY = 1e-30; // m^2, so that a slot without a spring divides by no zero

fn load_position(point: u32) -> vec3<f32> {
    return textureLoad(state, position_texel(point)).xyz;
}

fn load_velocity(point: u32) -> vec3<f32> {
    return textureLoad(state, velocity_texel(point)).xyz;
}

// Hooke's law for the springs of a point. The packets of all points with the same number follow one another. A slot
// that a point doesn't use joins it to itself: the force is zero.
fn gather_springs(i: u32, here: vec3<f32>, velocity: vec3<f32>) -> vec3<f32> {
    var force = vec3<f32>();
    var mask = 0u;
    if slots == SLOTS_SHIFTED {
        mask = masks[i];
    }
    for (var packet = 0u; packet < n_packets; packet++) {
        let at = packet * spring_step.n_points + i;
        var ends: vec4<u32>;
        var rest: vec4<f32>;
        var stiffness: vec4<f32>;
        if slots == SLOTS_LISTED {
            ends = textureLoad(springs, texel(3u * at));
            rest = bitcast<vec4<f32>>(textureLoad(springs, texel(3u * at + 1u)));
            stiffness = bitcast<vec4<f32>>(textureLoad(springs, texel(3u * at + 2u)));
        } else {
            rest = packets[packet].rest;
            stiffness = packets[packet].stiffness;
            if slots == SLOTS_ALIKE {
                ends = textureLoad(springs, texel(at));
            } else {
                let is_used = (vec4(mask >> (4u * packet)) & vec4(1u, 2u, 4u, 8u)) != vec4(0u);
                ends = vec4(i) + bitcast<vec4<u32>>(select(vec4(0i), packets[packet].shift, is_used));
            }
        }
        let d0 = load_position(ends.x) - here;
        let d1 = load_position(ends.y) - here;
        let d2 = load_position(ends.z) - here;
        let d3 = load_position(ends.w) - here;
        let inverse_length = inverseSqrt(max(vec4(dot(d0, d0), dot(d1, d1), dot(d2, d2), dot(d3, d3)), vec4(TINY)));
        var tension = stiffness * (1.0 - rest * inverse_length); // over the length
        if has_damping {
            let parting = vec4(
                dot(d0, load_velocity(ends.x) - velocity),
                dot(d1, load_velocity(ends.y) - velocity),
                dot(d2, load_velocity(ends.z) - velocity),
                dot(d3, load_velocity(ends.w) - velocity),
            );
            tension += spring_step.damping_s * stiffness * inverse_length * inverse_length * parting;
        }
        force += tension.x * d0 + tension.y * d1 + tension.z * d2 + tension.w * d3;
    }
    return force;
}

// The drag of the air on the triangles around a point: each feels 1/2 density coefficient area (u.n)|u.n| n, of which a
// corner takes a third; u is the velocity of the air past the triangle.
fn gather_drag(i: u32, here: vec3<f32>, velocity: vec3<f32>) -> vec3<f32> {
    var force = vec3<f32>();
    for (var fan = 0u; fan < n_fans; fan++) {
        let others = fans[fan * spring_step.n_points + i];
        let area_normal = cross(load_position(others.x) - here, load_position(others.y) - here); // twice the area
        let square = dot(area_normal, area_normal);
        if square > 0.0 {
            let mean = (velocity + load_velocity(others.x) + load_velocity(others.y)) / 3.0;
            let speed = dot(spring_step.wind - mean, area_normal) * inverseSqrt(square);
            force += spring_step.face_drag * speed * abs(speed) * area_normal;
        }
    }
    return force;
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let i = invocation.x;
    if i >= spring_step.n_points {
        return;
    }
    let here = textureLoad(state, position_texel(i));
    let motion = textureLoad(state, velocity_texel(i));
    var velocity = motion.xyz;
    if here.w > 0.0 {
        var force = gather_springs(i, here.xyz, velocity);
        if n_fans > 0u {
            force += gather_drag(i, here.xyz, velocity);
        }
        if has_forces {
            force += forces[i].xyz;
        }
        let drag = spring_step.drag_rate * (spring_step.wind - velocity);
        velocity += spring_step.kick_s * (here.w * force + spring_step.gravity + drag);
    }
    var position = here.xyz + spring_step.drift_s * velocity;
    let n_steps = select(motion.w, 0.0, spring_step.is_first != 0u) + 1.0;
    if n_obstacles > 0u && here.w > 0.0 {
        var particle = Particle(position, velocity);
        for (var k = 0u; k < n_obstacles; k++) {
            particle = collide(k, n_steps * spring_step.frame_part, spring_step.drift_s, particle);
        }
        position = particle.position;
        velocity = particle.velocity;
    }
    textureStore(next_state, position_texel(i), vec4(position, here.w));
    textureStore(next_state, velocity_texel(i), vec4(velocity, n_steps));
}
