// Four packed points of R^3 an invocation, three wide loads and three wide stores.
#import homogeneous

@group(0) @binding(1) var<storage, read> source: array<Vec4>;
@group(0) @binding(2) var<storage, read_write> destination: array<Vec4>;

fn transformed(m: Mat4, x: Real, y: Real, z: Real) -> Vec3 {
    return finished(m[0] * x + m[1] * y + m[2] * z + m[3]);
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= n_quads() {
        return;
    }
    let m = transform.target_from_source;
    let i = 3u * invocation.x;
    let a = source[i];
    let b = source[i + 1u];
    let c = source[i + 2u];
    let p = transformed(m, a.x, a.y, a.z);
    let q = transformed(m, a.w, b.x, b.y);
    let r = transformed(m, b.z, b.w, c.x);
    let s = transformed(m, c.y, c.z, c.w);
    let j = i + 3u * transform.first_quad;
    destination[j] = Vec4(p, q.x);
    destination[j + 1u] = Vec4(q.yz, r.xy);
    destination[j + 2u] = Vec4(r.z, s);
}
