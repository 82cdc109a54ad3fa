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
    let last = i32(floor(axis.start.x + axis.length_major + half_width));
    var x = i32(floor(axis.start.x - half_width));
    let is_first_hidden = is_hidden(line, t_at_column(axis, x));
    x++;
    while x <= last && is_hidden(line, t_at_column(axis, x)) == is_first_hidden {
        x++;
    }
    return select(EDGE_UNKNOWN, select(EDGE_SHOWN, EDGE_HIDDEN, is_first_hidden), x > last);
}
