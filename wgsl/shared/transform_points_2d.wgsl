// Four packed points of R^2 an invocation; the matrix is the planar one with an idle z row and column.
#import homogeneous

@group(0) @binding(1) var<storage, read> source: array<Vec4>;
@group(0) @binding(2) var<storage, read_write> destination: array<Vec4>;

fn transformed(m: Mat4, point: Vec2) -> Vec2 {
    return finished(m[0] * point.x + m[1] * point.y + m[3]).xy;
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= n_quads() {
        return;
    }
    let m = transform.target_from_source;
    let i = 2u * invocation.x;
    let a = source[i];
    let b = source[i + 1u];
    let j = i + 2u * transform.first_quad;
    destination[j] = Vec4(transformed(m, a.xy), transformed(m, a.zw));
    destination[j + 1u] = Vec4(transformed(m, b.xy), transformed(m, b.zw));
}
