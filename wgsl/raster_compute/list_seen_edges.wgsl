// Lists the edges that may be seen, in any order, a block of edges per invocation: all but those within a window of
// pixels whose faces are all nearer. Those that reach out of the view volume are listed too: to clip all takes longer.
#import clip_segment
#import depth_windows
#import line_style
#import tile

struct GrowingEdgeList {
    n_workgroups: atomic<u32>, // three counts, as dispatch_workgroups_indirect reads them
    n_workgroups_y: atomic<u32>,
    n_workgroups_z: atomic<u32>,
    n_edges: atomic<u32>,
    edges: array<u32>, // counted over all instances
}

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<uniform> style: LineStyle;
@group(0) @binding(2) var<storage, read> clip_positions: array<vec4<f32>>; // reversed-Z
@group(0) @binding(3) var<storage, read> edges: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> window_depths: array<u32>; // from find_window_depths.wgsl
@group(0) @binding(5) var<storage, read_write> seen_edges: GrowingEdgeList; // as EdgeList, zeros at first

override workgroup_size: u32;

const BLOCK_EDGES = 32u; // as many as a number has bits
const MAX_WORKGROUPS = 65535u; // that WebGPU lets a dispatch have
const ROUNDING_PX = 0.01; // by which a point of a segment may lie beside the rectangle around its ends

fn may_be_seen(index: u32, instance: u32) -> bool {
    let edge = edges[index];
    if edge.x == NO_POINT {
        return false;
    }
    let first_point = instance * style.instance_stride;
    let a = clip_positions[first_point + edge.x];
    let b = clip_positions[first_point + edge.y];
    if !is_in_view(a) || !is_in_view(b) {
        return true;
    }
    let p = clip_to_pixels(a, tile.size);
    let q = clip_to_pixels(b, tile.size);
    let first_pixel = vec2<i32>(floor(min(p, q) - ROUNDING_PX)) - tile.depth_origin;
    let last_pixel = vec2<i32>(floor(max(p, q) + ROUNDING_PX)) - tile.depth_origin;
    let cell = first_pixel / CELL_PX;
    let is_in_window = all(last_pixel < CELL_PX * (cell + 2)) && all(first_pixel >= vec2(0));
    let n_cells = cell_counts(tile);
    if !is_in_window || any(last_pixel >= tile.depth_extent) {
        return true;
    }
    return max(a.z / a.w, b.z / b.w) >= bitcast<f32>(window_depths[cell.y * n_cells.x + cell.x]);
}

fn list_block(block: u32, instance: u32) {
    let first = block * BLOCK_EDGES;
    let n = min(style.n_edges - first, BLOCK_EDGES);
    var mask = 0u;
    var i = 0u;
    loop {
        mask |= u32(may_be_seen(first + i, instance)) << i;
        i++;
        if i == n {
            break;
        }
    }
    if mask == 0u {
        return;
    }
    var place = atomicAdd(&seen_edges.n_edges, countOneBits(mask));
    let n_invocations = (place + countOneBits(mask)) << style.log2_lanes;
    let n_workgroups = min((n_invocations + workgroup_size - 1u) / workgroup_size, MAX_WORKGROUPS);
    atomicMax(&seen_edges.n_workgroups, n_workgroups);
    atomicStore(&seen_edges.n_workgroups_y, 1u);
    atomicStore(&seen_edges.n_workgroups_z, 1u);
    loop {
        seen_edges.edges[place] = instance * style.n_edges + first + firstTrailingBit(mask);
        place++;
        mask &= mask - 1u;
        if mask == 0u {
            break;
        }
    }
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    let n = (style.n_edges + BLOCK_EDGES - 1u) / BLOCK_EDGES;
    var block = invocation.x;
    if block >= n {
        return;
    }
    loop {
        list_block(block, invocation.y);
        block += n_workgroups.x * workgroup_size;
        if block >= n {
            break;
        }
    }
}
