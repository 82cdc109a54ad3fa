// What a driver must get right before its results are believed: long loops, and where the members of a struct lie.
struct SelfTest {
    entries: mat4x4<f32>,
    scalar: f32,
    count: u32,
}

@group(0) @binding(0) var<uniform> given: SelfTest;
@group(0) @binding(1) var<storage, read_write> seen: array<f32>;

@compute @workgroup_size(1)
fn main() {
    for (var column = 0u; column < 4u; column++) {
        for (var row = 0u; row < 4u; row++) {
            seen[4u * row + column] = given.entries[column][row];
        }
    }
    seen[16] = given.scalar;
    var iterations = 0u;
    for (var i = 0u; i < given.count; i++) {
        iterations += 1u + (i & 1u);
    }
    seen[17] = f32(iterations);
}
