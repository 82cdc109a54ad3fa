// Which of the lines through a pixel lies over the others: the nearest, of several at one distance the last. A key's upper
// bits tell how near an edge is, its lower ones which it is, counted from 1 over all instances.
#import edge_depth

fn key_at(line: Segment, t: f32, edge: u32) -> u32 {
    let nearness = 1.0 - farness_at(line, t);
    let steps = (1u << (32u - style.edge_bits)) - 1u;
    return (u32(nearness * f32(steps)) << style.edge_bits) | (edge + 1u);
}

fn edge_of(key: u32) -> u32 {
    return (key & ((1u << style.edge_bits) - 1u)) - 1u;
}
