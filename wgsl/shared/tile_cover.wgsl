// Vertices of the triangles that a render pass draws over a tile: one over all of it, or two over each segment.
#import clip_segment
#import tile

const COVER_MARGIN_PX = 0.1; // by which a quad is larger than what it must cover, for rounding

// Where a vertex is that belongs to nothing. It lies in the view volume, because lavapipe clips all the triangles of a
// batch one by one if one vertex lies outside.
const NOWHERE = vec4(0.0, 0.0, 0.0, 1.0);

// The three corners of a triangle over the tile.
fn tile_corner(corner: u32) -> vec4<f32> {
    return vec4(f32(corner & 1u) * 4.0 - 1.0, f32(corner >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

// The four corners of a quad over all pixels that a capsule around a segment touches.
fn segment_corner(line: Segment, half_width: f32, corner: u32, tile: Tile) -> vec4<f32> {
    if !line.is_valid {
        return NOWHERE;
    }
    let span = line.q - line.p;
    let length_px = length(span);
    let tangent = select(vec2(1.0, 0.0), span / length_px, length_px > 0.0);
    let normal = vec2(-tangent.y, tangent.x);
    // A pixel is drawn if its centre lies in the quad: half a pixel reaches so far along the segment, and across it.
    let reach = half_width + 0.5 * (abs(tangent.x) + abs(tangent.y)) + COVER_MARGIN_PX;
    let end = select(line.p - tangent * reach, line.q + tangent * reach, (corner & 1u) == 1u);
    let pixel = end + normal * select(-reach, reach, corner >= 2u) - vec2<f32>(tile.origin);
    return vec4((pixel / vec2<f32>(tile.extent) - 0.5) * vec2(2.0, -2.0), 0.0, 1.0);
}
