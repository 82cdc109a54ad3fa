// Matrices that take points to points, and what a stage does with a homogeneous result.
struct Transform {
    target_from_source: Mat4,
    undefined: Real, // the host's NaN, which WGSL itself cannot write down
    n_points: u32,
    first_quad: u32, // of the destination
}

const AS_IT_IS = 0u;
const DIVIDED_BY_W = 1u;
const NORMALIZED = 2u;

// Uniform, not storage: lavapipe loads a storage buffer anew for every invocation, a quarter of the whole time.
@group(0) @binding(0) var<uniform> transforms: array<Transform, 8>;
override workgroup_size: u32;
override finish: u32; // one of the three above

fn finished(h: Vec4) -> Vec3 {
    if finish == DIVIDED_BY_W {
        return select(Vec3(transforms[0].undefined), h.xyz / h.w, h.w != Real());
    }
    if finish == NORMALIZED {
        // Scaled first, so that squaring neither overflows nor underflows; what has no length stays as it is.
        let largest = max(abs(h.x), max(abs(h.y), abs(h.z)));
        let scaled = h.xyz / largest;
        return select(h.xyz, scaled / sqrt(dot(scaled, scaled)), largest > Real());
    }
    return h.xyz;
}
