// Aliased lines, one pixel wide, a quad per edge: each pixel keeps the depth key of the nearest edge through it, as in
// rasterize_aliased_lines.wgsl.
#import aliased_fragment
#import dash_start
#import dda
#import instanced_edge
#import line_opacity
#import line_style
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
@group(0) @binding(5) var<storage, read_write> depth_keys: array<atomic<u32>>; // or 1 if all pixels look the same
@group(0) @binding(6) var<storage, read> dash_starts: array<f32>; // of the edges of all instances

override hidden: u32; // one of HIDDEN_*
override dashes: u32; // one of DASHES_*
override is_silhouette: bool;
override has_flats: bool;
override has_depth_cue: bool;
override is_uniform_style: bool; // all pixels look the same: nobody asks which edge is the nearest
override is_instanced: bool; // there is more than one instance

@vertex
fn vertex_main(@builtin(vertex_index) vertex: u32) -> Corner {
    let edge = vertex >> 2u;
    let line = load_instance_segment(edge, 1.0);
    let position = segment_corner(line, 0.5, vertex & 3u, tile);
    return Corner(position, vec4(line.p, line.q), vec4(line.depth, line.inverse_w), line.t_clip, edge);
}

@fragment
fn fragment_main(in: Corner) {
    let dash_start = dash_start_of(in.edge);
    let line = Segment(in.ends.xy, in.ends.zw, in.depth_and_w.xy, in.depth_and_w.zw, in.t_clip, dash_start, true);
    let axis = major_axis(line);
    let pixel = tile.origin + vec2<i32>(in.position.xy);
    let step = select(pixel, pixel.yx, axis.is_steep);
    let columns = aliased_columns(axis);
    if step.x >= columns.x && step.x < columns.y && step.y == aliased_row(axis, step.x) {
        emit_aliased(pixel, in.edge, line, t_at_column(axis, step.x));
    }
}
