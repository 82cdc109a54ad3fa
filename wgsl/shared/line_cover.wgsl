// What a stage covers that composites lines: all of the tile, or, if edges are few, a quad over each.
// Entry declares: tile, style, clip_positions, edges, is_instanced, covers_edges.
#import instanced_edge
#import line_style
#import tile
#import tile_cover

fn line_cover_vertex(vertex: u32) -> vec4<f32> {
    if !covers_edges {
        return tile_corner(vertex);
    }
    let half_width = 0.5 * style.line_width;
    return segment_corner(load_instance_segment(vertex >> 2u, half_width + 1.0), half_width, vertex & 3u, tile);
}
