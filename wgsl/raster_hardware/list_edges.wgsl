// Lists the marked edges, a block of edges per invocation, and says how many quads to draw: first those of edges that
// are shown, then those of which it is not known.
#import edge_marks
#import line_style

struct IndexedDraw { // as drawIndexedIndirect reads it
    n_indices: u32,
    n_instances: u32,
    first_index: u32,
    first_vertex: u32,
    first_instance: u32,
}

const QUAD_INDICES = 6u;
const QUAD_VERTICES = 4u;

@group(0) @binding(0) var<uniform> style: LineStyle;
@group(0) @binding(1) var<storage, read> marks: array<array<u32, N_LISTS>>; // from mark_edges.wgsl
@group(0) @binding(2) var<storage, read> n_marked: array<u32>; // sums over groups
@group(0) @binding(3) var<storage, read_write> edge_list: array<u32>; // counted over all instances
@group(0) @binding(4) var<storage, read_write> draws: array<array<IndexedDraw, N_LISTS>>;

override workgroup_size: u32;
override quads_per_draw: u32;

// How many edges of a list come before a block.
fn count_before(place: u32, n_blocks: u32, list: u32) -> u32 {
    let group = place >> LOG2_FANOUT;
    let supergroup = group >> LOG2_FANOUT;
    var n = 0u;
    for (var i = 0u; i < supergroup; i++) {
        n += n_marked[supergroup_index(i, list)];
    }
    for (var i = supergroup << LOG2_FANOUT; i < group; i++) {
        n += n_marked[group_index(i, n_blocks, list)];
    }
    for (var i = group << LOG2_FANOUT; i < place; i++) {
        n += countOneBits(marks[i][list]);
    }
    return n;
}

fn first_in_list(list: u32) -> u32 {
    return select(0u, n_marked[sum_index(LIST_SHOWN)], list == LIST_UNKNOWN);
}

fn list_block(block: u32, n_blocks: u32, instance: u32) {
    let place = instance * count_blocks(style.n_edges) + block;
    let first = instance * style.n_edges + block * BLOCK_EDGES;
    for (var list = 0u; list < N_LISTS; list++) {
        var mask = marks[place][list];
        var next = first_in_list(list) + count_before(place, n_blocks, list);
        while mask != 0u {
            edge_list[next] = first + firstTrailingBit(mask);
            mask &= mask - 1u;
            next++;
        }
    }
}

fn plan_draw(draw: u32) {
    for (var list = 0u; list < N_LISTS; list++) {
        let n = n_marked[sum_index(list)];
        let first = min(draw * quads_per_draw, n);
        let n_quads = min(n - first, quads_per_draw);
        let first_vertex = QUAD_VERTICES * (first_in_list(list) + first);
        draws[draw][list] = IndexedDraw(QUAD_INDICES * n_quads, 1u, 0u, first_vertex, 0u);
    }
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    let n = count_blocks(style.n_edges);
    let stride = n_workgroups.x * workgroup_size;
    for (var block = invocation.x; block < n; block += stride) {
        list_block(block, n * n_workgroups.y, invocation.y);
    }
    if invocation.y == 0u {
        for (var draw = invocation.x; draw < arrayLength(&draws); draw += stride) {
            plan_draw(draw);
        }
    }
}
