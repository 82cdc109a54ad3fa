// Four packed points of R^3, as wide loads and stores move them.
#import homogeneous

struct Quad {
    a: Vec4,
    b: Vec4,
    c: Vec4,
}

const QUAD_LENGTH = 3u;

fn transformed(m: Mat4, x: Real, y: Real, z: Real) -> Vec3 {
    return finished(m[0] * x + m[1] * y + m[2] * z + m[3]);
}

fn transformed_quad(m: Mat4, quad: Quad) -> Quad {
    let p = transformed(m, quad.a.x, quad.a.y, quad.a.z);
    let q = transformed(m, quad.a.w, quad.b.x, quad.b.y);
    let r = transformed(m, quad.b.z, quad.b.w, quad.c.x);
    let s = transformed(m, quad.c.y, quad.c.z, quad.c.w);
    return Quad(Vec4(p, q.x), Vec4(q.yz, r.xy), Vec4(r.z, s));
}
