// Aliased lines, one pixel wide: each pixel keeps the depth key of the nearest edge through it.
#import aliased_fragment
#import dash_start
#import dda
#import line_opacity
#import line_style
#import load_segment
#import tile

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<uniform> style: LineStyle;
@group(0) @binding(2) var<storage, read> clip_positions: array<vec4<f32>>; // reversed-Z
@group(0) @binding(3) var<storage, read> edges: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> face_depths: array<u32>; // bits of floats, which order as the floats do
@group(0) @binding(5) var<storage, read_write> depth_keys: array<atomic<u32>>; // or 1 if all pixels look the same
@group(0) @binding(6) var<storage, read> dash_starts: array<f32>; // of the edges of all instances

override workgroup_size: u32;
override hidden: u32; // one of HIDDEN_*
override dashes: u32; // one of DASHES_*
override is_silhouette: bool;
override has_flats: bool;
override has_depth_cue: bool;
override is_uniform_style: bool; // all pixels look the same: nobody asks which edge is the nearest

fn rasterize(index: u32, instance: u32) {
    var line = load_segment(index, instance, 1.0);
    if !line.is_valid {
        return;
    }
    line.dash_start = dash_start_of(instance * style.n_edges + index);
    let axis = major_axis(line);
    let bounds = bounds_in_tile(axis, tile);
    let columns = aliased_columns(axis);
    var x = max(columns.x, bounds.x);
    let last = min(columns.y - 1, bounds.y);
    if x > last {
        return;
    }
    loop {
        let y = aliased_row(axis, x);
        if y >= bounds.z && y <= bounds.w {
            let pixel = pixel_at(axis, x, y);
            emit_aliased(pixel, instance * style.n_edges + index, line, t_at_column(axis, x));
        }
        x++;
        if x > last {
            break;
        }
    }
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    var index = invocation.x;
    if index >= style.n_edges {
        return;
    }
    loop {
        rasterize(index, invocation.y);
        index += n_workgroups.x * workgroup_size;
        if index >= style.n_edges {
            break;
        }
    }
}
