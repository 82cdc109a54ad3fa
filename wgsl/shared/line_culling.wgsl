// Which edges the pixels of a tile show.
// Entry declares: tile, style, face_depths, hidden, dashes, is_silhouette, has_flats, has_depth_cue.
#import dda
#import line_opacity
#import line_style
#import tile

const EDGE_HIDDEN = 0u; // no pixel of the tile shows it
const EDGE_SHOWN = 1u; // no face hides any of it
const EDGE_UNKNOWN = 2u; // faces may hide some of it

const MAX_PROBED_PX = 16.0; // of a segment: longer ones are seldom hidden, or shown, all along

fn is_beside_tile(line: Segment, reach: f32) -> bool {
    let first = vec2<f32>(tile.origin) - reach;
    let last = vec2<f32>(tile.origin + tile.extent) + reach;
    return any(max(line.p, line.q) < first) || any(min(line.p, line.q) > last);
}

// Whether faces hide a segment in all, none or some of the columns that its opacity is asked for. Wide lines are asked
// elsewhere too: not for them.
fn edge_visibility(line: Segment, half_width: f32) -> u32 {
    if !line.is_valid || is_beside_tile(line, half_width) {
        return EDGE_HIDDEN;
    }
    let axis = major_axis(line);
    if axis.length_major > MAX_PROBED_PX {
        return EDGE_UNKNOWN;
    }
    // Columns beside the segment ask for its ends.
    let last = i32(ceil(axis.start.x + axis.length_major - 0.5)) - 1;
    var x = i32(ceil(axis.start.x - 0.5));
    let is_start_hidden = is_hidden(line, 0.0);
    var is_same = is_hidden(line, 1.0) == is_start_hidden;
    loop {
        is_same = is_same && is_hidden(line, t_at_column(axis, x)) == is_start_hidden;
        x++;
        if x > last || !is_same {
            break;
        }
    }
    return select(EDGE_UNKNOWN, select(EDGE_SHOWN, EDGE_HIDDEN, is_start_hidden), is_same);
}
