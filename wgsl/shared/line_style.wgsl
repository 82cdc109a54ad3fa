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
    dash_period_px: f32,
    dash_begins: mat2x4<f32>, // of the pattern's dashes, pixels; those that it does not have lie far beyond its end
    dash_ends: mat2x4<f32>,
}

const HIDDEN_SHOW = 0u;
const HIDDEN_REMOVE = 1u;
const HIDDEN_DASH = 2u;
const HIDDEN_FADE = 3u;
const HIDDEN_ONLY = 4u; // nothing but what is hidden is drawn

const DASHES_NONE = 0u;
const DASHES_SIMPLE = 1u; // one dash, of a pixel or more, and one gap
const DASHES_COMPOUND = 2u;

const COLOR_UNIFORM = 0u;
const COLOR_PER_EDGE = 1u;
const COLOR_PER_VERTEX = 2u;
