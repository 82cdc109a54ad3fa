// Marks the edges that a tile shows, a block of edges per invocation.
#import edge_marks
#import line_culling
#import line_style
#import load_segment
#import tile

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<uniform> style: LineStyle;
@group(0) @binding(2) var<storage, read> clip_positions: array<vec4<f32>>; // reversed-Z
@group(0) @binding(3) var<storage, read> edges: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> face_depths: array<u32>; // bits of floats, which order as the floats do
@group(0) @binding(5) var<storage, read_write> marks: array<array<u32, N_LISTS>>; // of each block
@group(0) @binding(6) var<storage, read_write> n_marked: array<atomic<u32>>; // sums over groups, zeros at first

override workgroup_size: u32;
override hidden: u32; // HIDDEN_REMOVE
override dashes: u32; // one of DASHES_*
override is_silhouette: bool;
override has_flats: bool;
override has_depth_cue: bool;

fn add_marks(index: u32, n: u32) {
    if n > 0u {
        atomicAdd(&n_marked[index], n);
    }
}

fn mark_block(block: u32, n_blocks: u32, instance: u32) {
    let half_width = 0.5 * style.line_width;
    let first = block * BLOCK_EDGES;
    let n = min(style.n_edges - first, BLOCK_EDGES);
    var masks = array<u32, N_LISTS>();
    for (var i = 0u; i < n; i++) {
        let visibility = edge_visibility(load_segment(first + i, instance, half_width + 1.0), half_width);
        masks[LIST_SHOWN] |= u32(visibility == EDGE_SHOWN) << i;
        masks[LIST_UNKNOWN] |= u32(visibility == EDGE_UNKNOWN) << i;
    }
    let place = instance * count_blocks(style.n_edges) + block;
    marks[place] = masks;
    for (var list = 0u; list < N_LISTS; list++) {
        let n_own = countOneBits(masks[list]);
        add_marks(sum_index(list), n_own);
        add_marks(supergroup_index(place >> (2u * LOG2_FANOUT), list), n_own);
        add_marks(group_index(place >> LOG2_FANOUT, n_blocks, list), n_own);
    }
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    let n = count_blocks(style.n_edges);
    var block = invocation.x;
    if block >= n {
        return;
    }
    loop {
        mark_block(block, n * n_workgroups.y, invocation.y);
        block += n_workgroups.x * workgroup_size;
        if block >= n {
            break;
        }
    }
}
