// Four packed points of R^2 an invocation; the matrix is the planar one with an idle z row and column.
#import homogeneous

override divide_by_w: bool;

fn transformed(point: Vec2) -> Vec2 {
    let m = transform.target_from_source;
    let h = m[0] * point.x + m[1] * point.y + m[3];
    if divide_by_w {
        return select(Vec2(transform.undefined), h.xy / h.w, h.w != Real());
    }
    return h.xy;
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= transform.n_quads {
        return;
    }
    let i = 2u * invocation.x;
    let a = source[i];
    let b = source[i + 1u];
    destination[i] = Vec4(transformed(a.xy), transformed(a.zw));
    destination[i + 1u] = Vec4(transformed(b.xy), transformed(b.zw));
}
