// Points drawn as dots: what all of them share, and what a pixel keeps of those over it.
#import depth_cue

struct Splat {
    clip_from_points: mat4x4<f32>,
    depth_cue: DepthCue,
    color: vec4<f32>, // of all points if coloring is COLORING_UNIFORM, straight alpha
    scalar_row: vec4<f32>, // if coloring is COLORING_COORDINATE, times (point, 1): 0 to 1 over the colormap
    radius: f32, // pixels
    opacity: f32, // from 0 to 1
    first_packet: u32, // of a batch, and how many packets of four points there are from each to the next
    packet_stride: u32,
    n_points: u32, // of all batches
    n_colors: u32, // of the colormap
    writes_colors: u32, // in a second pass over the same points
}

const COLORING_UNIFORM = 0u;
const COLORING_COORDINATE = 1u; // a coordinate of the point, through the colormap
const COLORING_SCALAR = 2u; // a number per point from 0 to 1, or NaN, through the colormap
const COLORING_PACKED = 3u; // a colour per point

// The dots over a pixel: their absorbance, and of the two nearest the depths as the bits of floats, 0 for none.
struct PixelDots {
    depths: vec2<u32>,
    absorbance: u32,
    padding: u32,
}
// The points that may be seen, by index; the order is any.
struct PointList {
    end: u32,
    first: u32, // of the last batch
    points: array<u32>,
}

const BLOCK_SIDE = 4; // pixels of a block

fn blocks_across(width: i32) -> u32 {
    return u32(width + BLOCK_SIDE - 1) / u32(BLOCK_SIDE);
}
