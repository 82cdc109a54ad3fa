// Correlation of an image with a column of 8 numbers or more, as `convolve` does it. An invocation makes eight rows of
// one vector, which are summed as they come.
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
override source_format: u32;
override destination_format: u32;
override premultiplies: bool; // if a pixel is a vector
override unpremultiplies: bool;

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    if invocation.x >= parameters.n_blocks {
        return;
    }
    let y = 8u * (invocation.x / parameters.blocks_per_row);
    let x = invocation.x % parameters.blocks_per_row;
    let stride = parameters.source_stride;
    var i = y * stride + x;
    var column = Octet();
    column = add_to_octet(column, load_vector(i), coefficients[0].x, 0u, 0u);
    column = add_to_octet(column, load_vector(i + stride), coefficients[1].x, 0u, 1u);
    column = add_to_octet(column, load_vector(i + 2u * stride), coefficients[2].x, 0u, 2u);
    column = add_to_octet(column, load_vector(i + 3u * stride), coefficients[3].x, 0u, 3u);
    column = add_to_octet(column, load_vector(i + 4u * stride), coefficients[4].x, 0u, 4u);
    column = add_to_octet(column, load_vector(i + 5u * stride), coefficients[5].x, 0u, 5u);
    column = add_to_octet(column, load_vector(i + 6u * stride), coefficients[6].x, 0u, 6u);
    i += 7u * stride;
    for (var row = 7u; row < parameters.kernel_height; row++) {
        column = add_to_octet(column, load_vector(i), coefficients[row].x, 0u, 7u);
        i += stride;
    }
    column = add_to_octet(column, load_vector(i), Real(), 1u, 7u);
    column = add_to_octet(column, load_vector(i + stride), Real(), 2u, 7u);
    column = add_to_octet(column, load_vector(i + 2u * stride), Real(), 3u, 7u);
    column = add_to_octet(column, load_vector(i + 3u * stride), Real(), 4u, 7u);
    column = add_to_octet(column, load_vector(i + 4u * stride), Real(), 5u, 7u);
    column = add_to_octet(column, load_vector(i + 5u * stride), Real(), 6u, 7u);
    column = add_to_octet(column, load_vector(i + 6u * stride), Real(), 7u, 7u);
    store_octet(y * parameters.destination_stride + x, column, parameters.destination_stride);
}
