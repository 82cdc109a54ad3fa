// What an aliased line leaves in the pixels that it lights: the depth key of the nearest edge.
// Entry declares: tile, style, face_depths, depth_keys, hidden, dashes, is_silhouette, has_flats, has_depth_cue,
//     is_uniform_style.
#import dda
#import depth_key
#import edge_depth
#import line_opacity
#import line_style
#import tile

const MIN_SEEN_OPACITY = 0.5 / 255.0;

// The first column that a segment lights, and the one after the last: half open, so that a chain of edges lights each
// column once; but every edge lights a pixel.
fn aliased_columns(axis: MajorAxis) -> vec2<i32> {
    let begin = i32(ceil(axis.start.x - 0.5));
    return vec2(begin, max(i32(ceil(axis.start.x + axis.length_major - 0.5)), begin + 1));
}

// The pixel of a column that a segment lights.
fn aliased_row(axis: MajorAxis, x: i32) -> i32 {
    let distance_major = clamp(f32(x) + 0.5 - axis.start.x, 0.0, axis.length_major);
    return i32(floor(axis.start.y + axis.slope * distance_major));
}

fn emit_aliased(pixel: vec2<i32>, edge: u32, line: Segment, t: f32) {
    let index = pixel_index(tile, pixel);
    if is_uniform_style && hidden == HIDDEN_SHOW && dashes == DASHES_NONE {
        atomicStore(&depth_keys[index], 1u);
        return;
    }
    if (hidden == HIDDEN_SHOW && dashes == DASHES_NONE && !has_depth_cue) || opacity_at(line, t) >= MIN_SEEN_OPACITY {
        let depth = ordering_depth_at(line, pixel, style.depth_cue);
        atomicMax(&depth_keys[index], depth_key(depth, edge, style.edge_bits));
    }
}
