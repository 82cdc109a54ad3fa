// Composites lines of several colours over the picture, as opaque together as their absorbance says. The nearest edges
// of a pixel, in its k-buffer, each take what they leave no light through by themselves; the last one takes the rest.
#import absorbance
#import composite
#import coverage
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
@group(0) @binding(6) var<storage, read> absorbance: array<u32>; // from accumulate_lines.wgsl
@group(0) @binding(7) var<storage, read> k_buffer: array<u32>;
@group(0) @binding(8) var destination: texture_2d<f32>; // premultiplied
@group(0) @binding(9) var<storage, read> dash_starts: array<f32>; // of the edges of all instances

override hidden: u32; // one of HIDDEN_*
override dashes: u32; // one of DASHES_*
override is_silhouette: bool;
override has_flats: bool;
override has_depth_cue: bool;
override color_mode: u32; // one of COLOR_*
override k: u32; // depth keys per pixel, 2 or 4
override is_wide: bool; // opacity is asked for each pixel across a line, not once per column
override absorbance_steps_per_e: f32;
override covers_edges: bool; // a quad over each edge is drawn, not one triangle over the tile
override is_instanced: bool; // there is more than one instance
override is_first: bool; // nothing has been drawn yet: the background is the destination

@vertex
fn vertex_main(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return line_cover_vertex(vertex);
}

fn line_of_key(key: u32) -> Segment {
    let edge = edge_of_key(key, style.edge_bits);
    var line = load_instance_segment(edge, 0.5 * style.line_width + 1.0);
    line.dash_start = dash_start_of(edge);
    return line;
}

fn color_of_key(key: u32, pixel: vec2<i32>) -> vec4<f32> {
    let index = edge_index(edge_of_key(key, style.edge_bits));
    if color_mode == COLOR_PER_EDGE {
        return unpack4x8unorm(colors[index]);
    }
    let line = line_of_key(key);
    return color_at(index, line, t_at_pixel(line, pixel));
}

// How much of a pixel an edge leaves no light through by itself.
fn alpha_alone(key: u32, pixel: vec2<i32>) -> f32 {
    let line = line_of_key(key);
    let axis = major_axis(line);
    let covered = pixel_coverage(axis, 0.5 * style.line_width, pixel);
    return color_of_key(key, pixel).a * opacity_at(line, t_of_opacity(line, axis, pixel, is_wide)) * covered;
}

fn color_at_pixel(pixel: vec2<i32>) -> vec4<f32> {
    let index = pixel_index(tile, pixel);
    let slots = k * index;
    var key = k_buffer[slots];
    if key == 0u {
        return vec4(0.0);
    }
    let alpha = alpha_of(absorbance[index], absorbance_steps_per_e);
    var color = vec4(0.0);
    // A CPU goes through the loop once for nothing, and would so evaluate the last key again: it comes after the loop.
    var next = k_buffer[slots + 1u];
    for (var i = 2u; next != 0u; i++) {
        let share = min(alpha - color.a, (1.0 - color.a) * alpha_alone(key, pixel));
        color += vec4(color_of_key(key, pixel).rgb * share, share);
        key = next;
        next = select(0u, k_buffer[slots + min(i, k - 1u)], i < k);
    }
    let rest = alpha - color.a;
    return color + vec4(color_of_key(key, pixel).rgb * rest, rest);
}

@fragment
fn fragment_main(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    return composite_over(color_at_pixel(tile.origin + vec2<i32>(position.xy)), destination_at(position));
}
