// The opacity of a point of an edge: distance takes from it, and faces before the edge hide it.
// Entry declares: tile, style, face_depths, hidden, dashes, is_silhouette, has_flats, has_depth_cue.
#import clip_segment
#import edge_depth
#import flat_cover
#import line_style
#import tile

const HIDDEN_FADE_ALPHA = 0.25; // what hidden edges keep of their opacity if they fade
const SILHOUETTE_PROBE_PX = 1.5; // from a silhouette to where the faces that it bounds are no longer

fn is_behind(at: vec2<f32>, depth: f32) -> bool {
    return depth < bitcast<f32>(face_depths[depth_index(tile, vec2<i32>(floor(at)))]);
}

// Whether a face hides the part t of a segment. Within a pixel of a silhouette a round body comes far towards the eye:
// what hides a silhouette must do so on both of its sides.
fn is_hidden(line: Segment, t: f32) -> bool {
    let at = mix(line.p, line.q, t);
    let depth = mix(line.depth.x, line.depth.y, t);
    if has_flats && is_under_flat(at, depth) {
        return true;
    }
    if !is_silhouette || !is_behind(at, depth) {
        return is_behind(at, depth);
    }
    let span = line.q - line.p;
    let aside = vec2(-span.y, span.x) * (SILHOUETTE_PROBE_PX / max(length(span), 1e-6));
    return is_behind(at - aside, depth) && is_behind(at + aside, depth);
}

// How much of a pixel's length lies on a dash, at a distance along the chain; the first dash has the edge's cap.
fn dash_coverage(distance_px: f32) -> f32 {
    let phase = distance_px - floor(distance_px / style.dash_period_px) * style.dash_period_px;
    let first_end = style.dash_ends[0].x;
    let is_first = distance_px < first_end;
    if dashes == DASHES_SIMPLE {
        return clamp(min(select(phase, first_end, is_first), first_end - phase) + 0.5, 0.0, 1.0);
    }
    let begin = vec4(phase - 0.5);
    let end = vec4(phase + 0.5);
    let with_cap = style.dash_begins[0] - vec4(select(0.0, 1.0, is_first), 0.0, 0.0, 0.0);
    let covered = max(min(end, style.dash_ends[0]) - max(begin, with_cap), vec4(0.0))
        + max(min(end, style.dash_ends[1]) - max(begin, style.dash_begins[1]), vec4(0.0));
    let next = min(end.x - style.dash_period_px, first_end); // of the first dash of the period that follows
    return min(dot(covered, vec4(1.0)) + max(next, 0.0), 1.0);
}

fn dash_coverage_at(line: Segment, t: f32) -> f32 {
    return dash_coverage(abs(line.dash_start + t * distance(line.p, line.q)));
}

// The opacity that distance leaves at the part t of a segment, from 0 to 1.
fn cued_opacity_at(line: Segment, t: f32) -> f32 {
    if !has_depth_cue {
        return style.opacity;
    }
    return style.opacity * (1.0 - style.depth_cue.amount * normalized_depth_at(line, t, style.depth_cue));
}

// The opacity at the part t of a segment, from 0 to 1, less if a face hides it, and between dashes.
fn opacity_at(line: Segment, t: f32) -> f32 {
    var opacity = cued_opacity_at(line, t);
    if dashes != DASHES_NONE && hidden != HIDDEN_DASH {
        opacity *= dash_coverage_at(line, t);
    }
    if hidden == HIDDEN_SHOW {
        return opacity;
    }
    if hidden == HIDDEN_ONLY {
        return select(0.0, opacity, is_hidden(line, t));
    }
    if !is_hidden(line, t) {
        return opacity;
    }
    if hidden == HIDDEN_DASH {
        return opacity * dash_coverage_at(line, t);
    }
    return select(0.0, HIDDEN_FADE_ALPHA * opacity, hidden == HIDDEN_FADE);
}
