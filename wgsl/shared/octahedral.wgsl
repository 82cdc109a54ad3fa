// Unit vectors as points of an octahedron, unfolded into a square: two numbers of 16 bits. Meyer et al., "On
// floating-point normal vectors", 2010.
fn unpack_octahedral(packed: u32) -> vec3<f32> {
    let square = unpack2x16snorm(packed);
    let z = 1.0 - abs(square.x) - abs(square.y);
    let fold = max(-z, 0.0);
    return normalize(vec3(square - fold * select(vec2(-1.0), vec2(1.0), square >= vec2(0.0)), z));
}
