// A depth key orders the edges through a pixel: the nearest has the largest key, of several at one depth the last. The
// upper bits tell how near an edge is, the lower ones which it is, counted from 1 over all instances.
fn depth_key(normalized_depth: f32, edge: u32, edge_bits: u32) -> u32 {
    let steps = (1u << (32u - edge_bits)) - 1u;
    return (u32((1.0 - normalized_depth) * f32(steps)) << edge_bits) | (edge + 1u);
}

fn edge_of_key(key: u32, edge_bits: u32) -> u32 {
    return (key & ((1u << edge_bits) - 1u)) - 1u;
}
