// Pinned points that are moved: each gets its position, and the velocity with which it is to go on.
#import texel

struct Pin {
    position: vec3<f32>,
    point: u32,
    velocity: vec3<f32>,
}

@group(0) @binding(0) var<storage, read> pins: array<Pin>;
@group(0) @binding(1) var state: texture_storage_2d<rgba32float, write>;

override workgroup_size: u32;

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let k = invocation.x;
    if k >= arrayLength(&pins) {
        return;
    }
    let pin = pins[k];
    textureStore(state, position_texel(pin.point), vec4(pin.position, 0.0));
    textureStore(state, velocity_texel(pin.point), vec4(pin.velocity, 0.0));
}
