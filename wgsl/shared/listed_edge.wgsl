// Which edge a quad is drawn for.
// Entry declares: edge_list, is_listed.

fn listed_edge(quad_index: u32) -> u32 {
    if !is_listed {
        return quad_index;
    }
    return edge_list[quad_index];
}
