// Where an edge begins along its chain, so that dashes run on from edge to edge.
// Entry declares: dash_starts, dashes.
#import line_style

// In pixels, less than zero if the chain passes the edge from its end to its start: then it is where the edge ends,
// negated, and the absolute value of what one adds to it is the place along the chain either way.
fn dash_start_of(instance_edge: u32) -> f32 {
    if dashes == DASHES_NONE {
        return 0.0;
    }
    return dash_starts[instance_edge];
}
