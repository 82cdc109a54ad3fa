// Aliased lines, one pixel wide: each pixel keeps the depth key of the nearest edge through it.
#import dda
#import depth_key
#import edge_depth
#import line_opacity
#import line_style
#import load_segment
#import tile

const MIN_SEEN_OPACITY = 0.5 / 255.0;

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<uniform> style: LineStyle;
@group(0) @binding(2) var<storage, read> clip_positions: array<vec4<f32>>; // reversed-Z
@group(0) @binding(3) var<storage, read> edges: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> face_depths: array<u32>; // bits of floats, which order as the floats do
@group(0) @binding(5) var<storage, read_write> depth_keys: array<atomic<u32>>; // or 1 if all pixels look the same

override workgroup_size: u32;
override hidden: u32; // one of HIDDEN_*
override is_silhouette: bool;
override has_depth_cue: bool;
override is_uniform_style: bool; // all pixels look the same: nobody asks which edge is the nearest

fn rasterize(index: u32, instance: u32) {
    let line = load_segment(index, instance, 1.0);
    if !line.is_valid {
        return;
    }
    let axis = major_axis(line);
    let bounds = bounds_in_tile(axis, tile);
    // Half open, so that a chain of edges lights each column once; but every edge lights a pixel.
    let begin = i32(ceil(axis.start.x - 0.5));
    let end = max(i32(ceil(axis.start.x + axis.length_major - 0.5)), begin + 1);
    for (var x = max(begin, bounds.x); x < min(end, bounds.y + 1); x++) {
        let distance_major = clamp(f32(x) + 0.5 - axis.start.x, 0.0, axis.length_major);
        let y = i32(floor(axis.start.y + axis.slope * distance_major));
        if y < bounds.z || y > bounds.w {
            continue;
        }
        let slot = pixel_index(tile, pixel_at(axis, x, y));
        if is_uniform_style && hidden == HIDDEN_SHOW {
            atomicStore(&depth_keys[slot], 1u);
            continue;
        }
        let t = t_at_column(axis, x);
        if (hidden == HIDDEN_SHOW && !has_depth_cue) || opacity_at(line, t) >= MIN_SEEN_OPACITY {
            let depth = normalized_depth_at(line, t, style.depth_cue);
            atomicMax(&depth_keys[slot], depth_key(depth, instance * style.n_edges + index, style.edge_bits));
        }
    }
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    for (var index = invocation.x; index < style.n_edges; index += n_workgroups.x * workgroup_size) {
        rasterize(index, invocation.y);
    }
}
