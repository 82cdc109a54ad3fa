// One dispatch of a convolution: its sizes. Strides count vectors from one row to the next.
#import real

struct ConvolutionPass {
    scale: Real, // of every sum
    opaque: Real, // alpha of an opaque pixel
    zero: Real, // what is subtracted from integers: half their range makes sums, and the errors of sums, smaller
    offset_whole: Real, // what that takes from a result
    offset_fraction: Real,
    n_blocks: u32,
    blocks_per_row: u32,
    source_stride: u32,
    destination_stride: u32,
    kernel_height: u32,
    rows_per_sum: u32, // of the matrix
}
