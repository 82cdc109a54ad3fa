// A quad of points an invocation, through each of n_rows matrices: it is loaded once.
#import quad

@group(0) @binding(1) var<storage, read> source: array<Vec4>;
@group(0) @binding(2) var<storage, read_write> destination: array<Vec4>;

override n_rows: u32; // 1 to 4: a constant, so that each matrix is loaded for all invocations at once

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= n_quads() {
        return;
    }
    let i = QUAD_LENGTH * invocation.x;
    let quad = Quad(source[i], source[i + 1u], source[i + 2u]);
    for (var row = 0u; row < n_rows; row++) {
        let result = transformed_quad(transforms[row].target_from_source, quad);
        let j = i + QUAD_LENGTH * transforms[row].first_quad;
        destination[j] = result.a;
        destination[j + 1u] = result.b;
        destination[j + 2u] = result.c;
    }
}
