// Edges that no pixel shows.
// Entry declares: tile, style, face_depths, hidden, is_silhouette, has_depth_cue, is_wide.
#import dda
#import line_opacity
#import line_style

const MAX_PROBED_PX = 16.0; // of a segment: longer ones are seldom hidden all along

// Whether faces hide a segment in all the columns that its opacity is asked for. Wide lines are asked elsewhere too.
fn is_hidden_throughout(line: Segment) -> bool {
    let axis = major_axis(line);
    if hidden != HIDDEN_REMOVE || is_wide || axis.length_major > MAX_PROBED_PX {
        return false;
    }
    let half_width = 0.5 * style.line_width;
    let last = i32(floor(axis.start.x + axis.length_major + half_width));
    var x = i32(floor(axis.start.x - half_width));
    while x <= last && opacity_at(line, t_at_column(axis, x)) <= 0.0 {
        x++;
    }
    return x > last;
}
