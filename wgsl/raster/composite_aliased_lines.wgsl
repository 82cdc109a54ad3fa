// Composites aliased lines over the picture, in the colours of the nearest edge of each pixel.
#import composite
#import dash_start
#import dda
#import depth_key
#import destination
#import edge_color
#import instanced_edge
#import line_cover
#import line_opacity
#import line_style
#import tile

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<uniform> style: LineStyle;
@group(0) @binding(2) var<storage, read> clip_positions: array<vec4<f32>>; // reversed-Z
@group(0) @binding(3) var<storage, read> edges: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> face_depths: array<u32>; // bits of floats, which order as the floats do
@group(0) @binding(5) var<storage, read> colors: array<u32>; // as color_mode says, straight alpha
@group(0) @binding(6) var<storage, read> depth_keys: array<u32>; // or 1 if all pixels look the same; 0 without a line
@group(0) @binding(7) var destination: texture_2d<f32>; // premultiplied
@group(0) @binding(8) var<storage, read> dash_starts: array<f32>; // of the edges of all instances

override hidden: u32; // one of HIDDEN_*
override dashes: u32; // one of DASHES_*
override is_silhouette: bool;
override has_flats: bool;
override has_depth_cue: bool;
override color_mode: u32; // one of COLOR_*
override is_uniform_style: bool; // all pixels look the same
override covers_edges: bool; // a quad over each edge is drawn, not one triangle over the tile
override is_instanced: bool; // there is more than one instance
override is_first: bool; // nothing has been drawn yet: the background is the destination

@vertex
fn vertex_main(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return line_cover_vertex(vertex);
}

fn color_at_pixel(pixel: vec2<i32>) -> vec4<f32> {
    let key = depth_keys[pixel_index(tile, pixel)];
    if is_uniform_style {
        return premultiply(style.color, select(0.0, style.opacity, key != 0u));
    }
    if key == 0u {
        return vec4(0.0);
    }
    let edge = edge_of_key(key, style.edge_bits);
    var line = load_instance_segment(edge, 1.0);
    line.dash_start = dash_start_of(edge);
    let axis = major_axis(line);
    let t = t_of_opacity(line, axis, pixel, false);
    return premultiply(color_at(edge_index(edge), line, t), opacity_at(line, t));
}

@fragment
fn fragment_main(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    return composite_over(color_at_pixel(tile.origin + vec2<i32>(position.xy)), destination_at(position));
}
