// A quad of points an invocation, through each of n_rows matrices: it is loaded once. Both buffers hold whole workgroups,
// so that nothing asks whether a point is one: that would mask every load and store.
#import quad

@group(0) @binding(1) var<storage, read> source: array<Vec4>;
@group(0) @binding(2) var<storage, read_write> destination: array<Vec4>;

override n_rows: u32; // 1 to 4

fn put(first_quad: u32, index: u32, result: Quad) {
    let j = QUAD_LENGTH * (first_quad + index);
    destination[j] = result.a;
    destination[j + 1u] = result.b;
    destination[j + 2u] = result.c;
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let i = QUAD_LENGTH * invocation.x;
    let quad = Quad(source[i], source[i + 1u], source[i + 2u]);
    // No loop: at an index that it cannot see through, lavapipe loads a matrix anew for every invocation.
    put(transforms[0].first_quad, invocation.x, transformed_quad(transforms[0].target_from_source, quad));
    if n_rows > 1u {
        put(transforms[1].first_quad, invocation.x, transformed_quad(transforms[1].target_from_source, quad));
    }
    if n_rows > 2u {
        put(transforms[2].first_quad, invocation.x, transformed_quad(transforms[2].target_from_source, quad));
    }
    if n_rows > 3u {
        put(transforms[3].first_quad, invocation.x, transformed_quad(transforms[3].target_from_source, quad));
    }
}
