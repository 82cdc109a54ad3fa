// Anti-aliased lines of several colours, a quad per edge, to the absorbance of pixels and to their k-buffers, as
// accumulate_lines.wgsl.
#import coverage
#import dash_start
#import dda
#import instanced_edge
#import line_fragment
#import line_opacity
#import line_style
#import listed_edge
#import tile
#import tile_cover

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat, either) ends: vec4<f32>, // p and q of the segment
    @location(1) @interpolate(flat, either) depth_and_w: vec4<f32>, // depth at p and q, and 1 / w
    @location(2) @interpolate(flat, either) t_clip: vec2<f32>,
    @location(3) @interpolate(flat, either) edge: u32, // counted over all instances
}

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<uniform> style: LineStyle;
@group(0) @binding(2) var<storage, read> clip_positions: array<vec4<f32>>; // reversed-Z
@group(0) @binding(3) var<storage, read> edges: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> face_depths: array<u32>; // bits of floats, which order as the floats do
@group(0) @binding(5) var<storage, read> colors: array<u32>; // as color_mode says, straight alpha
@group(0) @binding(6) var<storage, read_write> absorbance: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> k_buffer: array<atomic<u32>>; // k keys per pixel, nearest first
@group(0) @binding(8) var<storage, read> edge_list: array<u32>; // from list_edges.wgsl
@group(0) @binding(9) var<storage, read> dash_starts: array<f32>; // of the edges of all instances

override is_listed: bool; // edges of the list are drawn, not all
override hidden: u32; // one of HIDDEN_*
override dashes: u32; // one of DASHES_*
override is_silhouette: bool;
override has_flats: bool;
override has_depth_cue: bool;
override color_mode: u32; // one of COLOR_*
override has_transparency: bool; // some of the colours are not opaque
override k: u32; // 2 or 4
override is_wide: bool; // opacity is asked for each pixel across a line, not once per column
override is_instanced: bool; // there is more than one instance
override absorbance_steps_per_e: f32;
override min_transmittance: f32; // of a line in a pixel
override may_overflow: bool; // there are so many lines that all through one pixel could be more than it holds

@vertex
fn vertex_main(@builtin(vertex_index) vertex: u32) -> Corner {
    let edge = listed_edge(vertex >> 2u);
    let half_width = 0.5 * style.line_width;
    let line = load_instance_segment(edge, half_width + 1.0);
    let position = segment_corner(line, half_width, vertex & 3u, tile);
    return Corner(position, vec4(line.p, line.q), vec4(line.depth, line.inverse_w), line.t_clip, edge);
}

@fragment
fn fragment_main(in: Corner) {
    let dash_start = dash_start_of(in.edge);
    let line = Segment(in.ends.xy, in.ends.zw, in.depth_and_w.xy, in.depth_and_w.zw, in.t_clip, dash_start, true);
    let axis = major_axis(line);
    let pixel = tile.origin + vec2<i32>(in.position.xy);
    let t = t_of_opacity(line, axis, pixel, is_wide);
    let opacity = color_alpha_at(edge_index(in.edge), line, t) * opacity_at(line, t);
    let alpha = opacity * pixel_coverage(axis, 0.5 * style.line_width, pixel);
    if alpha > 0.0 {
        emit_fragment(pixel, alpha, in.edge, line);
    }
}
