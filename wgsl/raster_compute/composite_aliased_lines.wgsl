// Composites aliased lines over the target, in the colours of the nearest edge of each pixel.
#import composite
#import dda
#import depth_key
#import edge_color
#import line_opacity
#import line_style
#import load_segment
#import tile

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<uniform> style: LineStyle;
@group(0) @binding(2) var<storage, read> clip_positions: array<vec4<f32>>; // reversed-Z
@group(0) @binding(3) var<storage, read> edges: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> face_depths: array<u32>; // bits of floats, which order as the floats do
@group(0) @binding(5) var<storage, read> colors: array<u32>; // as color_mode says, straight alpha
@group(0) @binding(6) var<storage, read> depth_keys: array<u32>; // from rasterize_aliased_lines.wgsl
@group(0) @binding(7) var<storage, read_write> render_target: array<u32>; // of the tile, premultiplied

override workgroup_size: u32;
override hidden: u32; // one of HIDDEN_*
override is_silhouette: bool;
override has_depth_cue: bool;
override color_mode: u32; // one of COLOR_*
override is_uniform_style: bool; // all pixels look the same
override is_first: bool = false; // nothing has been drawn yet, not even the background

// The next pixel with a line, from an index on; what lies before it becomes background if nothing has been drawn yet.
fn next_touched(first: u32, n: u32, stride: u32, background: u32) -> u32 {
    var index = first;
    while index < n && depth_keys[index] == 0u {
        if is_first {
            render_target[index] = background;
        }
        index += stride;
    }
    return index;
}

fn color_at_pixel(pixel_index: u32) -> vec4<f32> {
    if is_uniform_style {
        return premultiply(style.color, style.opacity);
    }
    let edge = edge_of_key(depth_keys[pixel_index], style.edge_bits);
    let index = edge % style.n_edges;
    let line = load_segment(index, edge / style.n_edges, 1.0);
    let axis = major_axis(line);
    let pixel = pixel_at_index(tile, pixel_index);
    let t = t_at_column(axis, select(pixel.x, pixel.y, axis.is_steep));
    return premultiply(color_at(index, line, t), opacity_at(line, t));
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    let stride = n_workgroups.x * workgroup_size;
    let n = n_pixels(tile);
    let background = pack4x8unorm(tile.background);
    var index = invocation.x;
    loop {
        // Each invocation looks for its next pixel first: on a CPU, masked work costs as much as work that is done.
        index = next_touched(index, n, stride, background);
        if index >= n {
            break;
        }
        let destination = select(unpack4x8unorm(render_target[index]), tile.background, is_first);
        render_target[index] = pack4x8unorm(composite_over(color_at_pixel(index), destination));
        index += stride;
    }
}
