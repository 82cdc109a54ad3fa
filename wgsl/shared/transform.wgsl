// A matrix that takes points to points, and what follows the product with it.
#import real

struct Transform {
    target_from_source: Mat4,
    nan: Real, // from the host: WGSL itself cannot write it down
    n_points: u32,
    first_packet: u32, // of the destination
}

const MATRICES_PER_DISPATCH = 8;

const EPILOGUE_NONE = 0u;
const EPILOGUE_PERSPECTIVE_DIVIDE = 1u;
const EPILOGUE_NORMALIZE = 2u;

// The point of R^3 that a homogeneous result becomes; `epilogue` is one of the three constants above.
fn apply_epilogue(h: Vec4, epilogue: u32, nan: Real) -> Vec3 {
    if epilogue == EPILOGUE_PERSPECTIVE_DIVIDE {
        return select(Vec3(nan), h.xyz / h.w, h.w != Real());
    }
    if epilogue == EPILOGUE_NORMALIZE {
        // Scaled first, so that squaring neither overflows nor underflows; a vector without length stays as it is.
        let largest = max(abs(h.x), max(abs(h.y), abs(h.z)));
        let scaled = h.xyz / largest;
        return select(h.xyz, scaled / sqrt(dot(scaled, scaled)), largest > Real());
    }
    return h.xyz;
}
