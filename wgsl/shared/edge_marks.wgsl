// Two lists of edges: those that are shown, and those of which that is not known. Before they are lists they are marks,
// a bit per edge in each block of edges, and sums of them over groups of blocks. So the edges keep their order,
// whichever invocation comes first.
const LIST_SHOWN = 0u;
const LIST_UNKNOWN = 1u;
const N_LISTS = 2u;

const BLOCK_EDGES = 32u; // of one instance: as many as a number has bits
const LOG2_FANOUT = 5u; // blocks per group, and groups per supergroup

// Where the sums lie: first those of all, then those of supergroups, then those of groups.
fn sum_index(list: u32) -> u32 {
    return list;
}

fn supergroup_index(supergroup: u32, list: u32) -> u32 {
    return N_LISTS * (1u + supergroup) + list;
}

fn group_index(group: u32, n_blocks: u32, list: u32) -> u32 {
    let n_supergroups = (n_blocks + (1u << (2u * LOG2_FANOUT)) - 1u) >> (2u * LOG2_FANOUT);
    return N_LISTS * (1u + n_supergroups + group) + list;
}

fn count_blocks(n_edges: u32) -> u32 {
    return (n_edges + BLOCK_EDGES - 1u) / BLOCK_EDGES;
}
