// What both kinds of line are drawn from.
struct Picture {
    size: vec2<f32>, // pixels
    line_width: f32, // pixels
    n_colors: u32, // 1, or one an edge
}

@group(0) @binding(0) var<uniform> picture: Picture;
@group(0) @binding(1) var<storage, read> projected: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> edges: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read> colors: array<u32>;

// The colour of an edge, straight alpha.
fn edge_color(edge: u32) -> vec4<f32> {
    return unpack4x8unorm(colors[min(edge, picture.n_colors - 1u)]);
}
