// Pinned points that are moved: each gets its position, and the velocity with which it is to go on.
struct Pin {
    position: vec3<f32>,
    point: u32,
    velocity: vec3<f32>,
}

@group(0) @binding(0) var<storage, read> pins: array<Pin>;
@group(0) @binding(1) var<storage, read_write> positions: array<vec4<f32>>; // w: 1 / mass, 0 here
@group(0) @binding(2) var<storage, read_write> velocities: array<vec4<f32>>; // w: steps of the frame

override workgroup_size: u32;

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let k = invocation.x;
    if k >= arrayLength(&pins) {
        return;
    }
    let pin = pins[k];
    positions[pin.point] = vec4(pin.position, 0.0);
    velocities[pin.point] = vec4(pin.velocity, 0.0);
}
