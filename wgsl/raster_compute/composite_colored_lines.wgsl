// Composites lines of several colours over the target, as opaque together as their absorbance says. The nearest edges
// of a pixel, in its k-buffer, each take what they leave no light through by themselves; the last one takes the rest.
#import absorbance
#import composite
#import coverage
#import dda
#import depth_key
#import edge_color
#import line_opacity
#import line_style
#import load_segment
#import tile

struct TouchedPixels {
    n: u32,
    indices: array<u32>,
}

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<uniform> style: LineStyle;
@group(0) @binding(2) var<storage, read> clip_positions: array<vec4<f32>>; // reversed-Z
@group(0) @binding(3) var<storage, read> edges: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> face_depths: array<u32>; // bits of floats, which order as the floats do
@group(0) @binding(5) var<storage, read> colors: array<u32>; // as color_mode says, straight alpha
@group(0) @binding(6) var<storage, read> absorbance: array<u32>; // from accumulate_lines.wgsl
@group(0) @binding(7) var<storage, read> touched_pixels: TouchedPixels;
@group(0) @binding(8) var<storage, read> k_buffer: array<u32>;
@group(0) @binding(9) var<storage, read_write> render_target: array<u32>; // of the tile, premultiplied

override workgroup_size: u32;
override hidden: u32; // one of HIDDEN_*
override is_silhouette: bool;
override has_depth_cue: bool;
override color_mode: u32; // one of COLOR_*
override k: u32; // depth keys per pixel, 2 or 4
override is_wide: bool; // opacity is asked for each pixel across a line, not once per column
override absorbance_steps_per_e: f32;
override is_listed: bool; // the pixels with absorbance are few, and listed in touched_pixels
override is_first: bool = false; // nothing has been drawn yet, not even the background

fn line_of_key(key: u32) -> Segment {
    let edge = edge_of_key(key, style.edge_bits);
    return load_segment(edge % style.n_edges, edge / style.n_edges, 0.5 * style.line_width + 1.0);
}

fn color_of_key(key: u32, pixel: vec2<i32>) -> vec4<f32> {
    let index = edge_of_key(key, style.edge_bits) % style.n_edges;
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
    let half_width = 0.5 * style.line_width;
    let step = select(pixel, pixel.yx, axis.is_steep);
    let covered = coverage(column_spans(axis, half_width, edge_offset(axis, half_width), step.x), step.y);
    let t = select(t_at_column(axis, step.x), t_at_pixel(line, pixel), is_wide);
    return color_of_key(key, pixel).a * opacity_at(line, t) * covered;
}

fn color_at_pixel(index: u32) -> vec4<f32> {
    let alpha = alpha_of(absorbance[index], absorbance_steps_per_e);
    let pixel = pixel_at_index(tile, index);
    let slots = k * index;
    var color = vec4(0.0);
    var key = k_buffer[slots];
    for (var i = 1u; key != 0u; i++) {
        // A CPU takes both ways of an `if`, but ends a loop that none of those in step goes on with.
        let next = select(0u, k_buffer[slots + min(i, k - 1u)], i < k);
        var share = alpha - color.a;
        for (var others = min(next, 1u); others > 0u; others--) {
            share = min(share, (1.0 - color.a) * alpha_alone(key, pixel));
        }
        color += vec4(color_of_key(key, pixel).rgb * share, share);
        key = next;
    }
    return color;
}

// The next pixel with absorbance, from an index on; what lies before it becomes background if nothing has been drawn
// yet.
fn next_touched(first: u32, n: u32, stride: u32, background: u32) -> u32 {
    var index = first;
    while index < n && absorbance[index] == 0u {
        if is_first {
            render_target[index] = background;
        }
        index += stride;
    }
    return index;
}

fn composite_pixel(index: u32) {
    let destination = select(unpack4x8unorm(render_target[index]), tile.background, is_first);
    render_target[index] = pack4x8unorm(composite_over(color_at_pixel(index), destination));
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    let stride = n_workgroups.x * workgroup_size;
    if is_listed {
        let n_touched = touched_pixels.n;
        for (var i = invocation.x; i < n_touched; i += stride) {
            composite_pixel(touched_pixels.indices[i]);
        }
        return;
    }
    let n = n_pixels(tile);
    let background = pack4x8unorm(tile.background);
    var index = invocation.x;
    loop {
        // Each invocation looks for its next pixel first: on a CPU, masked work costs as much as work that is done.
        index = next_touched(index, n, stride, background);
        if index >= n {
            break;
        }
        composite_pixel(index);
        index += stride;
    }
}
