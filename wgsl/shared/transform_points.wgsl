// Four packed points of R^3 an invocation: three wide loads, three wide stores.
#import homogeneous

override divide_by_w: bool;

fn transformed(x: Real, y: Real, z: Real) -> Vec3 {
    let m = transform.target_from_source;
    let h = m[0] * x + m[1] * y + m[2] * z + m[3];
    if divide_by_w {
        return select(Vec3(transform.undefined), h.xyz / h.w, h.w != Real());
    }
    return h.xyz;
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= transform.n_quads {
        return;
    }
    let i = 3u * invocation.x;
    let a = source[i];
    let b = source[i + 1u];
    let c = source[i + 2u];
    let p = transformed(a.x, a.y, a.z);
    let q = transformed(a.w, b.x, b.y);
    let r = transformed(b.z, b.w, c.x);
    let s = transformed(c.y, c.z, c.w);
    destination[i] = Vec4(p, q.x);
    destination[i + 1u] = Vec4(q.yz, r.xy);
    destination[i + 2u] = Vec4(r.z, s);
}
