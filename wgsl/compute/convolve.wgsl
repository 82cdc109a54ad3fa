// Correlation of an image with a small matrix. An invocation makes a block of two rows of four vectors.
//
// A vector is four numbers of a row, whose pixels have one to four each. Rows are padded on the way in, by borders and
// to whole blocks, so that nothing here asks where the image ends. No tap is added that the matrix does not have: a
// zero in its place would make NaN of an infinite pixel. What `convolve_column` and `convolve_pixels` do is done by
// stages of their own, as a driver may take ten times as long to compile all three.
#import real
#import convolution_pass
#import image_vectors
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
override kernel_width: u32; // compiled in, because columns are unrolled by fours
override n_channels: u32; // of a pixel, 1 to 4
override source_format: u32;
override destination_format: u32;
override premultiplies: bool; // if a pixel is a vector
override unpremultiplies: bool;
// Sums of sums have smaller errors than one long sum, and take longer.
override sums_quads: bool; // taps of four columns by themselves first
override sums_rows: bool; // then those of each row

fn load_strip(i: u32) -> Strip {
    return Strip(load_vector(i), load_vector(i + 1u), load_vector(i + 2u), load_vector(i + 3u), load_vector(i + 4u));
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

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= parameters.n_blocks {
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
    for (var row = 1u; row < parameters.kernel_height; row++) {
        let begins = sums_rows && row % parameters.rows_per_sum == 0u;
        if begins {
            sums.top = add_blocks(sums.top, some.top);
            some.top = Block();
        }
        i += stride;
        some = add_row(some, i, k + vectors_per_row, k, true, true);
        k += vectors_per_row;
        if begins {
            sums.bottom = add_blocks(sums.bottom, some.bottom);
            some.bottom = Block();
        }
    }
    some = add_row(some, i + stride, 0u, k, false, true);
    sums = add_both(sums, some);
    let j = y * parameters.destination_stride + x;
    store_block(j, sums.top);
    store_block(j + parameters.destination_stride, sums.bottom);
}
