// How lines look, and what of them a dispatch draws.
#import depth_cue

struct LineStyle {
    depth_cue: DepthCue,
    color: vec4<f32>, // of all edges if color_mode is COLOR_UNIFORM, straight alpha
    line_width: f32, // pixels
    opacity: f32, // of all edges, from 0 to 1
    n_edges: u32, // of each instance
    instance_stride: u32, // points from one instance to the next in the clip positions
    edge_bits: u32, // of a depth key: which edge it is; 8 to 31, so that depth has no more bits than a float
    log2_lanes: u32, // invocations per edge, each of which takes every so many-th column
}

const HIDDEN_SHOW = 0u;
const HIDDEN_REMOVE = 1u;
const HIDDEN_DASH = 2u;
const HIDDEN_FADE = 3u;

const COLOR_UNIFORM = 0u;
const COLOR_PER_EDGE = 1u;
const COLOR_PER_VERTEX = 2u;
