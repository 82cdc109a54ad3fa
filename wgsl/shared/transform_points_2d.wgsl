// A quad of points an invocation, through each of n_rows matrices: it is loaded once. Both buffers hold whole workgroups,
// so that nothing asks whether a point is one: that would mask every load and store.
#import quad_2d

@group(0) @binding(1) var<storage, read> source: array<Vec4>;
@group(0) @binding(2) var<storage, read_write> destination: array<Vec4>;

override n_rows: u32; // 1 to 8

fn put(row: u32, quad_index: u32, quad: Quad) {
    let result = transformed_quad(transforms[row].target_from_source, quad);
    let j = QUAD_LENGTH * (transforms[row].first_quad + quad_index);
    destination[j] = result.a;
    destination[j + 1u] = result.b;
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let i = QUAD_LENGTH * invocation.x;
    let quad = Quad(source[i], source[i + 1u]);
    // No loop: at an index that it cannot see through, lavapipe loads a matrix anew for every invocation.
    put(0u, invocation.x, quad);
    if n_rows > 1u { put(1u, invocation.x, quad); }
    if n_rows > 2u { put(2u, invocation.x, quad); }
    if n_rows > 3u { put(3u, invocation.x, quad); }
    if n_rows > 4u { put(4u, invocation.x, quad); }
    if n_rows > 5u { put(5u, invocation.x, quad); }
    if n_rows > 6u { put(6u, invocation.x, quad); }
    if n_rows > 7u { put(7u, invocation.x, quad); }
}
