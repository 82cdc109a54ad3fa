// Correlation of an image with a small matrix, a block of two rows of four vectors per invocation; with a column of
// eight numbers or more, a block of eight rows of one vector.
//
// A vector is four numbers of a row, whose pixels have one to four each. Rows are padded on the way in, by borders and
// to whole blocks, so that nothing here asks where the image ends. No tap is added that the matrix does not have: a
// zero in its place would make NaN of an infinite pixel.
#import real
#import convolution_pass
#import pixel_format
#import strip

@group(0) @binding(0) var<uniform> parameters: ConvolutionPass;
// Four columns per vector; each row of the matrix begins with a new one. Uniform, not storage: lavapipe loads what
// is in a storage buffer anew for every invocation.
@group(0) @binding(1) var<uniform> coefficients: UniformVec4s;
// Of each pair of views one is used: the other is an idle buffer.
@group(0) @binding(2) var<storage, read> source: array<Vec4>;
@group(0) @binding(3) var<storage, read> source_words: array<u32>;
@group(0) @binding(4) var<storage, read_write> destination: array<Vec4>;
@group(0) @binding(5) var<storage, read_write> destination_words: array<u32>;

override workgroup_size: u32;
override is_column: bool; // the matrix is one of 8 rows or more, summed as they come
override kernel_width: u32; // compiled in, because columns are unrolled by fours
override n_channels: u32; // of a pixel, 1 to 4
override source_format: u32;
override destination_format: u32;
override premultiplies: bool; // if a pixel is a vector
override unpremultiplies: bool;
// Sums of sums have smaller errors than one long sum, and take longer.
override sums_quads: bool; // taps of four columns by themselves first
override sums_rows: bool; // then those of each row

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

fn load_strip(i: u32) -> Strip {
    return Strip(load_vector(i), load_vector(i + 1u), load_vector(i + 2u), load_vector(i + 3u), load_vector(i + 4u));
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

fn store_block(i: u32, block: Block) {
    store_vector(i, block.a);
    store_vector(i + 1u, block.b);
    store_vector(i + 2u, block.c);
    store_vector(i + 3u, block.d);
}

// Two rows of outputs, and the rows of the matrix that the next row of the image meets for each. One of them may meet
// none; which is known where this is called.
struct TwoRows {
    top: Block,
    bottom: Block,
}

fn add_tap_to_both(sums: TwoRows, strip: Strip, top: Real, bottom: Real, has_top: bool, has_bottom: bool) -> TwoRows {
    var result = sums;
    if has_top { result.top = add_tap(sums.top, strip, top); }
    if has_bottom { result.bottom = add_tap(sums.bottom, strip, bottom); }
    return result;
}

fn add_both(s: TwoRows, t: TwoRows) -> TwoRows {
    return TwoRows(add_blocks(s.top, t.top), add_blocks(s.bottom, t.bottom));
}

// What four taps of a row leave: their sums, the strip that the next four begin with, and the next vector after it.
struct Taps {
    sums: TwoRows,
    strip: Strip,
    next: u32,
}

fn slide_taps(taps: Taps) -> Taps {
    return Taps(taps.sums, slide(taps.strip, load_vector(taps.next)), taps.next + 1u);
}

// Up to four taps by coefficients of the top and of the bottom row, each tap a pixel on from the last.
fn add_quad(start: Taps, t: Vec4, b: Vec4, n_taps: u32, has_top: bool, has_bottom: bool) -> Taps {
    var taps = start;
    taps.sums = add_tap_to_both(taps.sums, taps.strip, t.x, b.x, has_top, has_bottom);
    if n_taps > 1u {
        var strip = taps.strip;
        if n_channels == 1u {
            strip = shift_by_one(strip);
        } else if n_channels == 2u {
            strip = shift_by_two(strip);
        } else if n_channels == 3u {
            strip = shift_by_three(strip);
        } else {
            taps = slide_taps(taps);
            strip = taps.strip;
        }
        taps.sums = add_tap_to_both(taps.sums, strip, t.y, b.y, has_top, has_bottom);
    }
    if n_taps > 2u {
        var strip = taps.strip;
        if n_channels == 1u {
            strip = shift_by_two(strip);
        } else {
            taps = slide_taps(taps);
            strip = taps.strip;
            if n_channels == 3u { strip = shift_by_two(strip); }
        }
        taps.sums = add_tap_to_both(taps.sums, strip, t.z, b.z, has_top, has_bottom);
    }
    if n_taps > 3u {
        var strip = taps.strip;
        if n_channels == 1u {
            strip = shift_by_three(strip);
        } else if n_channels == 2u {
            strip = shift_by_two(strip);
        } else {
            taps = slide_taps(taps);
            strip = taps.strip;
            if n_channels == 3u { strip = shift_by_one(strip); }
        }
        taps.sums = add_tap_to_both(taps.sums, strip, t.w, b.w, has_top, has_bottom);
        taps = slide_taps(taps);
    }
    return taps;
}

// The row of the image at vector `i`, by the rows of the matrix at the vectors `top` and `bottom` of the coefficients.
fn add_row(sums: TwoRows, i: u32, top: u32, bottom: u32, has_top: bool, has_bottom: bool) -> TwoRows {
    var taps = Taps(sums, load_strip(i), i + 5u);
    if sums_rows {
        taps.sums = TwoRows();
    }
    let n_quads = kernel_width / 4u;
    for (var i_quad = 0u; i_quad < n_quads; i_quad++) {
        let before = taps.sums;
        if sums_quads {
            taps.sums = TwoRows();
        }
        taps = add_quad(taps, coefficients[top + i_quad], coefficients[bottom + i_quad], 4u, has_top, has_bottom);
        if sums_quads {
            taps.sums = add_both(before, taps.sums);
        }
    }
    if kernel_width % 4u > 0u {
        let t = coefficients[top + n_quads];
        taps = add_quad(taps, t, coefficients[bottom + n_quads], kernel_width % 4u, has_top, has_bottom);
    }
    if sums_rows {
        return add_both(sums, taps.sums);
    }
    return taps.sums;
}

// Eight rows of outputs. `k` holds what the next row of the image is multiplied by, for each of them.
struct Column {
    a: Vec4,
    b: Vec4,
    c: Vec4,
    d: Vec4,
    e: Vec4,
    f: Vec4,
    g: Vec4,
    h: Vec4,
    k: array<Real, 8>,
}

// The next row of the image into the sums of rows `first` to `last`, which are known where this is called.
fn add_to_column(column: Column, next: Vec4, coefficient: Real, first: u32, last: u32) -> Column {
    var result = column;
    let k = column.k;
    result.k = array(coefficient, k[0], k[1], k[2], k[3], k[4], k[5], k[6]);
    if first <= 0u { result.a = fma(Vec4(coefficient), next, column.a); }
    if first <= 1u && last >= 1u { result.b = fma(Vec4(k[0]), next, column.b); }
    if first <= 2u && last >= 2u { result.c = fma(Vec4(k[1]), next, column.c); }
    if first <= 3u && last >= 3u { result.d = fma(Vec4(k[2]), next, column.d); }
    if first <= 4u && last >= 4u { result.e = fma(Vec4(k[3]), next, column.e); }
    if first <= 5u && last >= 5u { result.f = fma(Vec4(k[4]), next, column.f); }
    if first <= 6u && last >= 6u { result.g = fma(Vec4(k[5]), next, column.g); }
    if last >= 7u { result.h = fma(Vec4(k[6]), next, column.h); }
    return result;
}

fn convolve_column(block: u32) {
    let y = 8u * (block / parameters.blocks_per_row);
    let x = block % parameters.blocks_per_row;
    let stride = parameters.source_stride;
    var i = y * stride + x;
    var column = Column();
    column = add_to_column(column, load_vector(i), coefficients[0].x, 0u, 0u);
    column = add_to_column(column, load_vector(i + stride), coefficients[1].x, 0u, 1u);
    column = add_to_column(column, load_vector(i + 2u * stride), coefficients[2].x, 0u, 2u);
    column = add_to_column(column, load_vector(i + 3u * stride), coefficients[3].x, 0u, 3u);
    column = add_to_column(column, load_vector(i + 4u * stride), coefficients[4].x, 0u, 4u);
    column = add_to_column(column, load_vector(i + 5u * stride), coefficients[5].x, 0u, 5u);
    column = add_to_column(column, load_vector(i + 6u * stride), coefficients[6].x, 0u, 6u);
    i += 7u * stride;
    for (var row = 7u; row < parameters.kernel_height; row++) {
        column = add_to_column(column, load_vector(i), coefficients[row].x, 0u, 7u);
        i += stride;
    }
    column = add_to_column(column, load_vector(i), Real(), 1u, 7u);
    column = add_to_column(column, load_vector(i + stride), Real(), 2u, 7u);
    column = add_to_column(column, load_vector(i + 2u * stride), Real(), 3u, 7u);
    column = add_to_column(column, load_vector(i + 3u * stride), Real(), 4u, 7u);
    column = add_to_column(column, load_vector(i + 4u * stride), Real(), 5u, 7u);
    column = add_to_column(column, load_vector(i + 5u * stride), Real(), 6u, 7u);
    column = add_to_column(column, load_vector(i + 6u * stride), Real(), 7u, 7u);
    let step = parameters.destination_stride;
    let j = y * step + x;
    store_vector(j, column.a);
    store_vector(j + step, column.b);
    store_vector(j + 2u * step, column.c);
    store_vector(j + 3u * step, column.d);
    store_vector(j + 4u * step, column.e);
    store_vector(j + 5u * step, column.f);
    store_vector(j + 6u * step, column.g);
    store_vector(j + 7u * step, column.h);
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= parameters.n_blocks {
        return;
    }
    if is_column {
        convolve_column(invocation.x);
        return;
    }
    let y = 2u * (invocation.x / parameters.blocks_per_row);
    let x = 4u * (invocation.x % parameters.blocks_per_row);
    let stride = parameters.source_stride;
    let vectors_per_row = (kernel_width + 3u) / 4u;
    var i = y * stride + x;
    var k = 0u;
    // The bottom row of outputs meets each row of the matrix one row of the image later, and sums them alike.
    var sums = TwoRows();
    var some = add_row(TwoRows(), i, 0u, 0u, true, false);
    for (var row = 1u; row < min(parameters.rows_per_sum, parameters.kernel_height); row++) {
        i += stride;
        some = add_row(some, i, k + vectors_per_row, k, true, true);
        k += vectors_per_row;
    }
    if sums_rows {
        for (var first = parameters.rows_per_sum; first < parameters.kernel_height; first += parameters.rows_per_sum) {
            sums.top = add_blocks(sums.top, some.top);
            some.top = Block();
            i += stride;
            some = add_row(some, i, k + vectors_per_row, k, true, true);
            k += vectors_per_row;
            sums.bottom = add_blocks(sums.bottom, some.bottom);
            some.bottom = Block();
            let last = min(first + parameters.rows_per_sum, parameters.kernel_height);
            for (var row = first + 1u; row < last; row++) {
                i += stride;
                some = add_row(some, i, k + vectors_per_row, k, true, true);
                k += vectors_per_row;
            }
        }
    }
    some = add_row(some, i + stride, 0u, k, false, true);
    sums = add_both(sums, some);
    let j = y * parameters.destination_stride + x;
    store_block(j, sums.top);
    store_block(j + parameters.destination_stride, sums.bottom);
}
