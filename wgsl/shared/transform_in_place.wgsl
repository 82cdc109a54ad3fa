// A quad of points an invocation, written where it was read: half the memory to pass through the caches.
// The buffer holds whole workgroups, as that of transform_points.
#import quad

@group(0) @binding(1) var<storage, read_write> points: array<Vec4>;

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let i = QUAD_LENGTH * invocation.x;
    let result = transformed_quad(transforms[0].target_from_source, Quad(points[i], points[i + 1u], points[i + 2u]));
    points[i] = result.a;
    points[i + 1u] = result.b;
    points[i + 2u] = result.c;
}
