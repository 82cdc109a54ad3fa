// A packet: four packed points, as wide loads and stores move them. It is three vectors for points of R^3 and two for
// points of R^2, as many as a point has components.
#import real
#import transform

struct Packet {
    a: Vec4,
    b: Vec4,
    c: Vec4, // idle in R^2
}

fn transform_3d(transform: Transform, epilogue: u32, x: Real, y: Real, z: Real) -> Vec3 {
    let m = transform.target_from_source;
    return apply_epilogue(m[0] * x + m[1] * y + m[2] * z + m[3], epilogue, transform.nan);
}

// The matrix has an idle z row and column.
fn transform_2d(transform: Transform, epilogue: u32, point: Vec2) -> Vec2 {
    let m = transform.target_from_source;
    return apply_epilogue(m[0] * point.x + m[1] * point.y + m[3], epilogue, transform.nan).xy;
}

fn transform_packet(transform: Transform, epilogue: u32, n_components: u32, packet: Packet) -> Packet {
    if n_components == 2u {
        let a = Vec4(transform_2d(transform, epilogue, packet.a.xy), transform_2d(transform, epilogue, packet.a.zw));
        let b = Vec4(transform_2d(transform, epilogue, packet.b.xy), transform_2d(transform, epilogue, packet.b.zw));
        return Packet(a, b, Vec4());
    }
    let p = transform_3d(transform, epilogue, packet.a.x, packet.a.y, packet.a.z);
    let q = transform_3d(transform, epilogue, packet.a.w, packet.b.x, packet.b.y);
    let r = transform_3d(transform, epilogue, packet.b.z, packet.b.w, packet.c.x);
    let s = transform_3d(transform, epilogue, packet.c.y, packet.c.z, packet.c.w);
    return Packet(Vec4(p, q.x), Vec4(q.yz, r.xy), Vec4(r.z, s));
}
