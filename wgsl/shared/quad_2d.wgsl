// Four packed points of R^2, as wide loads and stores move them; a matrix has an idle z row and column.
#import homogeneous

struct Quad {
    a: Vec4,
    b: Vec4,
}

const QUAD_LENGTH = 2u;

fn transformed(m: Mat4, point: Vec2) -> Vec2 {
    return finished(m[0] * point.x + m[1] * point.y + m[3]).xy;
}

fn transformed_quad(m: Mat4, quad: Quad) -> Quad {
    let a = Vec4(transformed(m, quad.a.xy), transformed(m, quad.a.zw));
    let b = Vec4(transformed(m, quad.b.xy), transformed(m, quad.b.zw));
    return Quad(a, b);
}
