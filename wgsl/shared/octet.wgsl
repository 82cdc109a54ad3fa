// Eight neighbours of outputs, in a column or, if a vector is a pixel, in a row.
// Entry declares: parameters, source, source_words, destination, destination_words, source_format, destination_format,
//     premultiplies, unpremultiplies.
#import real
#import image_vectors

struct Octet {
    a: Vec4,
    b: Vec4,
    c: Vec4,
    d: Vec4,
    e: Vec4,
    f: Vec4,
    g: Vec4,
    h: Vec4,
    k: array<Real, 7>, // what the next vector of the image is multiplied by for each but the first
}

// The next vector of the image into the sums from number `first` to `last`, which are known where this is called.
fn add_to_octet(octet: Octet, next: Vec4, coefficient: Real, first: u32, last: u32) -> Octet {
    var result = octet;
    let k = octet.k;
    result.k = array(coefficient, k[0], k[1], k[2], k[3], k[4], k[5]);
    if first <= 0u { result.a = fma(Vec4(coefficient), next, octet.a); }
    if first <= 1u && last >= 1u { result.b = fma(Vec4(k[0]), next, octet.b); }
    if first <= 2u && last >= 2u { result.c = fma(Vec4(k[1]), next, octet.c); }
    if first <= 3u && last >= 3u { result.d = fma(Vec4(k[2]), next, octet.d); }
    if first <= 4u && last >= 4u { result.e = fma(Vec4(k[3]), next, octet.e); }
    if first <= 5u && last >= 5u { result.f = fma(Vec4(k[4]), next, octet.f); }
    if first <= 6u && last >= 6u { result.g = fma(Vec4(k[5]), next, octet.g); }
    if last >= 7u { result.h = fma(Vec4(k[6]), next, octet.h); }
    return result;
}

fn store_octet(j: u32, octet: Octet, step: u32) {
    store_vector(j, octet.a);
    store_vector(j + step, octet.b);
    store_vector(j + 2u * step, octet.c);
    store_vector(j + 3u * step, octet.d);
    store_vector(j + 4u * step, octet.e);
    store_vector(j + 5u * step, octet.f);
    store_vector(j + 6u * step, octet.g);
    store_vector(j + 7u * step, octet.h);
}
