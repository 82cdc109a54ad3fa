// The segment of an edge of an instance.
// Entry declares: tile, style, clip_positions, edges.
#import clip_segment
#import line_style
#import tile

fn load_segment(index: u32, instance: u32, margin_px: f32) -> Segment {
    let edge = edges[index];
    if edge.x == NO_POINT {
        return Segment();
    }
    let first = instance * style.instance_stride;
    return clip_segment(clip_positions[first + edge.x], clip_positions[first + edge.y], margin_px, tile.size);
}
