// Edges counted over all instances.
// Entry declares: tile, style, clip_positions, edges, is_instanced.
#import clip_segment
#import line_style
#import load_segment

// The index of an edge in its instance. Divisions are dear, and seldom needed.
fn edge_index(instance_edge: u32) -> u32 {
    if !is_instanced {
        return instance_edge;
    }
    return instance_edge % style.n_edges;
}

fn load_instance_segment(instance_edge: u32, margin_px: f32) -> Segment {
    if !is_instanced {
        return load_segment(instance_edge, 0u, margin_px);
    }
    return load_segment(instance_edge % style.n_edges, instance_edge / style.n_edges, margin_px);
}
