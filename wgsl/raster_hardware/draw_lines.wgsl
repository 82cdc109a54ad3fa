// Anti-aliased lines of one colour, a quad per edge: how opaque each is in a pixel, for a target that holds the product
// of what all let through.
#import coverage
#import dash_start
#import dda
#import instanced_edge
#import line_opacity
#import line_style
#import listed_edge
#import tile
#import tile_cover

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat, either) ends: vec4<f32>, // p and q of the segment
    @location(1) @interpolate(flat, either) depth_and_w: vec4<f32>, // depth at p and q, and 1 / w
    @location(2) @interpolate(flat, either) dash_start: f32,
}

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<uniform> style: LineStyle;
@group(0) @binding(2) var<storage, read> clip_positions: array<vec4<f32>>; // reversed-Z
@group(0) @binding(3) var<storage, read> edges: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> face_depths: array<u32>; // bits of floats, which order as the floats do
@group(0) @binding(5) var<storage, read> edge_list: array<u32>; // from list_edges.wgsl
@group(0) @binding(6) var<storage, read> dash_starts: array<f32>; // of the edges of all instances

override is_listed: bool; // edges of the list are drawn, not all
override hidden: u32; // one of HIDDEN_*
override dashes: u32; // one of DASHES_*
override is_silhouette: bool;
override has_flats: bool;
override has_depth_cue: bool;
override is_wide: bool; // opacity is asked for each pixel across a line, not once per column
override is_instanced: bool; // there is more than one instance

@vertex
fn vertex_main(@builtin(vertex_index) vertex: u32) -> Corner {
    let half_width = 0.5 * style.line_width;
    let edge = listed_edge(vertex >> 2u);
    let line = load_instance_segment(edge, half_width + 1.0);
    let position = segment_corner(line, half_width, vertex & 3u, tile);
    return Corner(position, vec4(line.p, line.q), vec4(line.depth, line.inverse_w), dash_start_of(edge));
}

@fragment
fn fragment_main(in: Corner) -> @location(0) vec4<f32> {
    let t_clip = vec2(0.0, 1.0);
    let line = Segment(in.ends.xy, in.ends.zw, in.depth_and_w.xy, in.depth_and_w.zw, t_clip, in.dash_start, true);
    let axis = major_axis(line);
    let pixel = tile.origin + vec2<i32>(in.position.xy);
    let opacity = style.color.a * opacity_at(line, t_of_opacity(line, axis, pixel, is_wide));
    return vec4(opacity * pixel_coverage(axis, 0.5 * style.line_width, pixel));
}
