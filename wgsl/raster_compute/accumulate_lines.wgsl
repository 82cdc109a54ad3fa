// Anti-aliased lines to the absorbance of pixels, in which the order of lines does not matter. Of lines of several
// colours, each pixel keeps the depth keys of its nearest edges as well: a k-buffer, which says in what colours light
// is absorbed. Bavoil et al., "Multi-fragment effects on the GPU using the k-buffer", 2007.
#import coverage
#import dash_start
#import dda
#import line_fragment
#import line_opacity
#import line_style
#import load_segment
#import tile

struct EdgeList {
    n_workgroups: u32, // three counts, as dispatch_workgroups_indirect reads them
    n_workgroups_y: u32,
    n_workgroups_z: u32,
    n_edges: u32,
    edges: array<u32>, // counted over all instances
}

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<uniform> style: LineStyle;
@group(0) @binding(2) var<storage, read> clip_positions: array<vec4<f32>>; // reversed-Z
@group(0) @binding(3) var<storage, read> edges: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> face_depths: array<u32>; // bits of floats, which order as the floats do
@group(0) @binding(5) var<storage, read> colors: array<u32>; // as color_mode says, straight alpha
@group(0) @binding(6) var<storage, read_write> absorbance: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> k_buffer: array<atomic<u32>>; // k keys per pixel, nearest first
@group(0) @binding(8) var<storage, read> dash_starts: array<f32>; // of the edges of all instances
@group(0) @binding(9) var<storage, read> seen_edges: EdgeList; // from list_seen_edges.wgsl

override workgroup_size: u32;
override is_listed: bool; // edges of the list are drawn, not all
override is_instanced: bool; // there is more than one instance
override hidden: u32; // one of HIDDEN_*
override dashes: u32; // one of DASHES_*
override is_silhouette: bool;
override has_flats: bool;
override has_depth_cue: bool;
override color_mode: u32; // one of COLOR_*; COLOR_UNIFORM leaves the k-buffer as it is
override has_transparency: bool; // some of the colours are not opaque
override k: u32; // 2 or 4
override is_wide: bool; // opacity is asked for each pixel across a line, not once per column
override absorbance_steps_per_e: f32;
override min_transmittance: f32; // of a line in a pixel
override may_overflow: bool; // there are so many lines that all through one pixel could be more than it holds

// Every so many-th column of an edge, as one of several invocations takes them.
fn rasterize(index: u32, instance: u32, lane: u32) {
    let half_width = 0.5 * style.line_width;
    var line = load_segment(index, instance, half_width + 1.0);
    if !line.is_valid {
        return;
    }
    line.dash_start = dash_start_of(instance * style.n_edges + index);
    let axis = major_axis(line);
    let offset = edge_offset(axis, half_width);
    let bounds = bounds_in_tile(axis, tile);
    var x = max(i32(floor(axis.start.x - half_width)), bounds.x) + i32(lane);
    let last = min(i32(floor(axis.start.x + axis.length_major + half_width)), bounds.y);
    if x > last {
        return;
    }
    loop {
        var opacity = 0.0;
        if !is_wide {
            let t = t_at_column(axis, x);
            opacity = color_alpha_at(index, line, t) * opacity_at(line, t);
        }
        if is_wide || (hidden == HIDDEN_SHOW && dashes == DASHES_NONE) || opacity > 0.0 {
            let spans = column_spans(axis, half_width, offset, x);
            let rows = row_range(spans);
            let highest = min(rows.y, bounds.w);
            var y = max(rows.x, bounds.z);
            loop {
                let pixel = pixel_at(axis, x, y);
                if is_wide {
                    let t = t_at_pixel(line, pixel);
                    opacity = color_alpha_at(index, line, t) * opacity_at(line, t);
                }
                let alpha = select(0.0, opacity * coverage(spans, y), y <= highest);
                emit_fragment(pixel, alpha, instance * style.n_edges + index, line);
                y++;
                if y > highest {
                    break;
                }
            }
        }
        x += 1 << style.log2_lanes;
        if x > last {
            break;
        }
    }
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    var n_edges = style.n_edges;
    if is_listed {
        n_edges = seen_edges.n_edges;
    }
    let n = n_edges << style.log2_lanes;
    var i = invocation.x;
    if i >= n {
        return;
    }
    loop {
        var index = i >> style.log2_lanes;
        var instance = invocation.y;
        if is_listed {
            index = seen_edges.edges[index];
            if is_instanced {
                instance = index / style.n_edges;
                index -= instance * style.n_edges;
            }
        }
        rasterize(index, instance, i & ((1u << style.log2_lanes) - 1u));
        i += n_workgroups.x * workgroup_size;
        if i >= n {
            break;
        }
    }
}
