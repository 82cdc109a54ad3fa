// Vectors of four numbers of an image, from a buffer and into one.
// Entry declares: parameters, source, source_words, destination, destination_words, source_format, destination_format,
//     premultiplies, unpremultiplies.
#import real
#import convolution_pass
#import pixel_format

fn load_vector(i: u32) -> Vec4 {
    var v: Vec4;
    if source_format == FORMAT_UINT8 {
        v = unpack_bytes(source_words[i]) - parameters.zero;
    } else if source_format == FORMAT_UINT16 {
        v = unpack_halves(vec2(source_words[2u * i], source_words[2u * i + 1u])) - parameters.zero;
    } else {
        v = source[i];
    }
    if premultiplies {
        v = Vec4(v.xyz * v.w, v.w);
    }
    return v;
}

// To the nearest, ties to even.
fn round_integers(v: Vec4) -> Vec4 {
    return round(v + parameters.offset_fraction) + parameters.offset_whole;
}

fn store_vector(i: u32, sum: Vec4) {
    var v = sum * parameters.scale;
    if unpremultiplies {
        v = unpremultiply(v, parameters.opaque);
    }
    if destination_format == FORMAT_UINT8 {
        destination_words[i] = pack_bytes(round_integers(v));
    } else if destination_format == FORMAT_UINT16 {
        let halves = pack_halves(round_integers(v));
        destination_words[2u * i] = halves.x;
        destination_words[2u * i + 1u] = halves.y;
    } else {
        destination[i] = v;
    }
}
