// The opacity of a point of an edge: distance takes from it, and faces before the edge hide it.
// Entry declares: tile, style, face_depths, hidden, is_silhouette, has_depth_cue.
#import clip_segment
#import edge_depth
#import line_style
#import tile

const HIDDEN_FADE_ALPHA = 0.25; // what hidden edges keep of their opacity if they fade
const DASH_ON_WIDTHS = 4.0; // line widths
const DASH_OFF_WIDTHS = 3.0;
const MIN_DASH_WIDTH_PX = 1.5; // thinner lines are dashed as if they were as wide
const SILHOUETTE_PROBE_PX = 1.5; // from a silhouette to where the faces that it bounds are no longer

fn is_behind(at: vec2<f32>, depth: f32) -> bool {
    return depth < bitcast<f32>(face_depths[depth_index(tile, vec2<i32>(floor(at)))]);
}

// Whether a face hides the part t of a segment. Within a pixel of a silhouette a round body comes far towards the eye:
// what hides a silhouette must do so on both of its sides.
fn is_hidden(line: Segment, t: f32) -> bool {
    let at = mix(line.p, line.q, t);
    let depth = mix(line.depth.x, line.depth.y, t);
    if !is_silhouette || !is_behind(at, depth) {
        return is_behind(at, depth);
    }
    let span = line.q - line.p;
    let aside = vec2(-span.y, span.x) * (SILHOUETTE_PROBE_PX / max(length(span), 1e-6));
    return is_behind(at - aside, depth) && is_behind(at + aside, depth);
}

// How much of a pixel's length lies on a dash, at a distance along the chain; the first dash has the edge's cap.
fn dash_coverage(distance_px: f32) -> f32 {
    let pattern = vec2(DASH_ON_WIDTHS, DASH_OFF_WIDTHS) * max(style.line_width, MIN_DASH_WIDTH_PX);
    let period = pattern.x + pattern.y;
    let phase = distance_px - floor(distance_px / period) * period;
    let from_start = select(phase, pattern.x, distance_px < pattern.x);
    return clamp(min(from_start, pattern.x - phase) + 0.5, 0.0, 1.0);
}

// The opacity that distance leaves at the part t of a segment, from 0 to 1.
fn cued_opacity_at(line: Segment, t: f32) -> f32 {
    if !has_depth_cue {
        return style.opacity;
    }
    return style.opacity * (1.0 - style.depth_cue.amount * normalized_depth_at(line, t, style.depth_cue));
}

// The opacity at the part t of a segment, from 0 to 1, less if a face hides it.
fn opacity_at(line: Segment, t: f32) -> f32 {
    let opacity = cued_opacity_at(line, t);
    if hidden == HIDDEN_SHOW {
        return opacity;
    }
    if !is_hidden(line, t) {
        return opacity;
    }
    if hidden == HIDDEN_DASH {
        return opacity * dash_coverage(abs(line.dash_start + t * distance(line.p, line.q)));
    }
    return select(0.0, HIDDEN_FADE_ALPHA * opacity, hidden == HIDDEN_FADE);
}
