// Correlation of an image of four channels with a small matrix that is not too wide to sum its columns as they come, as
// `convolve` does it. An invocation makes two rows of eight pixels, each of which is a vector.
#import real
#import convolution_pass
#import image_vectors
#import octet

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
override kernel_width: u32; // compiled in, because it decides which sums a column meets
override source_format: u32;
override destination_format: u32;
override premultiplies: bool; // if a pixel is a vector
override unpremultiplies: bool;
override sums_rows: bool; // those of each row first, as `convolve` has it

// Two rows of eight pixels.
struct Octets {
    top: Octet,
    bottom: Octet,
}

fn add_octet(s: Octet, t: Octet) -> Octet {
    return Octet(s.a + t.a, s.b + t.b, s.c + t.c, s.d + t.d, s.e + t.e, s.f + t.f, s.g + t.g, s.h + t.h, s.k);
}

// A row of the image, and the rows of the matrix that it meets, as `add_row` of `convolve` has it.
struct Row {
    i: u32,
    top: u32,
    bottom: u32,
    has_top: bool,
    has_bottom: bool,
}

// Pixel number `column` of a row into the sums from `first` to `last` of both rows.
fn add_pixel(sums: Octets, row: Row, column: u32, first: u32, last: u32) -> Octets {
    var result = sums;
    let next = load_vector(row.i + column);
    let vector = min(column, kernel_width - 1u) / 4u;
    if row.has_top {
        result.top = add_to_octet(sums.top, next, coefficients[row.top + vector][column % 4u], first, last);
    }
    if row.has_bottom {
        result.bottom = add_to_octet(sums.bottom, next, coefficients[row.bottom + vector][column % 4u], first, last);
    }
    return result;
}

// The same for the first pixels, and for the last, of which narrow matrices meet some only.
fn add_early_pixel(sums: Octets, row: Row, column: u32) -> Octets {
    return add_pixel(sums, row, column, max(column + 1u, kernel_width) - kernel_width, column);
}

fn add_late_pixel(sums: Octets, row: Row, number: u32) -> Octets {
    let column = max(kernel_width, 7u) + number;
    if column > kernel_width + 6u {
        return sums;
    }
    return add_pixel(sums, row, column, column + 1u - kernel_width, 7u);
}

fn add_pixels(sums: Octets, row: Row) -> Octets {
    var result = sums;
    if sums_rows {
        result = Octets();
    }
    result = add_early_pixel(result, row, 0u);
    result = add_early_pixel(result, row, 1u);
    result = add_early_pixel(result, row, 2u);
    result = add_early_pixel(result, row, 3u);
    result = add_early_pixel(result, row, 4u);
    result = add_early_pixel(result, row, 5u);
    result = add_early_pixel(result, row, 6u);
    for (var column = 7u; column < kernel_width; column++) {
        result = add_pixel(result, row, column, 0u, 7u);
    }
    result = add_late_pixel(result, row, 0u);
    result = add_late_pixel(result, row, 1u);
    result = add_late_pixel(result, row, 2u);
    result = add_late_pixel(result, row, 3u);
    result = add_late_pixel(result, row, 4u);
    result = add_late_pixel(result, row, 5u);
    result = add_late_pixel(result, row, 6u);
    if sums_rows {
        return Octets(add_octet(sums.top, result.top), add_octet(sums.bottom, result.bottom));
    }
    return result;
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= parameters.n_blocks {
        return;
    }
    let y = 2u * (invocation.x / parameters.blocks_per_row);
    let x = 8u * (invocation.x % parameters.blocks_per_row);
    let stride = parameters.source_stride;
    let vectors_per_row = (kernel_width + 3u) / 4u;
    var i = y * stride + x;
    var k = 0u;
    // In the order of `convolve`.
    var sums = Octets();
    var some = add_pixels(Octets(), Row(i, 0u, 0u, true, false));
    for (var row = 1u; row < parameters.kernel_height; row++) {
        let begins = sums_rows && row % parameters.rows_per_sum == 0u;
        if begins {
            sums.top = add_octet(sums.top, some.top);
            some.top = Octet();
        }
        i += stride;
        some = add_pixels(some, Row(i, k + vectors_per_row, k, true, true));
        k += vectors_per_row;
        if begins {
            sums.bottom = add_octet(sums.bottom, some.bottom);
            some.bottom = Octet();
        }
    }
    some = add_pixels(some, Row(i + stride, 0u, k, false, true));
    let j = y * parameters.destination_stride + x;
    store_octet(j, add_octet(sums.top, some.top), 1u);
    store_octet(j + parameters.destination_stride, add_octet(sums.bottom, some.bottom), 1u);
}
