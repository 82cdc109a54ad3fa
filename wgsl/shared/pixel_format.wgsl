// Four numbers of an image as buffers hold them, and alpha.
#import real

const FORMAT_REAL = 0u;
const FORMAT_UINT8 = 1u;
const FORMAT_UINT16 = 2u;

fn unpack_bytes(word: u32) -> Vec4 {
    return Vec4(vec4(word, word >> 8u, word >> 16u, word >> 24u) & vec4(0xffu));
}

fn unpack_halves(words: vec2<u32>) -> Vec4 {
    return Vec4(vec4(words.x & 0xffffu, words.x >> 16u, words.y & 0xffffu, words.y >> 16u));
}

// Integers, clamped.
fn pack_bytes(v: Vec4) -> u32 {
    let n = vec4<u32>(clamp(v, Vec4(), Vec4(Real(255))));
    return n.x | (n.y << 8u) | (n.z << 16u) | (n.w << 24u);
}

fn pack_halves(v: Vec4) -> vec2<u32> {
    let n = vec4<u32>(clamp(v, Vec4(), Vec4(Real(65535))));
    return vec2(n.x | (n.y << 16u), n.z | (n.w << 16u));
}

// Colours weighted by alpha, divided by it after it is clamped; without alpha there is no colour.
fn unpremultiply(v: Vec4, opaque: Real) -> Vec4 {
    let alpha = clamp(v.w, Real(), opaque);
    if alpha > Real() {
        return Vec4(v.xyz / alpha, alpha);
    }
    return Vec4();
}
