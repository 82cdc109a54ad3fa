// How strongly a place of an edge is drawn: faces before it hide it, and distance pales it.
#import edge_depth

@group(0) @binding(4) var<storage, read> face_depths: array<u32>; // bits of floats, which order as the floats do

override hidden: u32; // what is done with an edge behind a face
override is_cued: bool; // distance pales it
override is_outline: bool; // faces turn away from the eye along it

const HIDDEN_SHOW = 0u;
const HIDDEN_REMOVE = 1u;
const HIDDEN_DASH = 2u;
const HIDDEN_FADE = 3u;

const PALE = 0.25; // what hidden edges keep of their strength where they fade
const DASH = vec2(4.0, 3.0); // on and off, in line widths

const BESIDE = 1.5; // pixels from an outline to where the faces that it bounds are no longer

fn is_behind(at: vec2<f32>, depth: f32) -> bool {
    return depth < bitcast<f32>(face_depths[depth_index(vec2<i32>(floor(at)))]);
}

// Whether a face hides the part t of a segment. Within a pixel of an outline a round body comes far towards the eye: what
// hides an outline must do so on its both sides.
fn is_hidden(line: Segment, t: f32) -> bool {
    let at = mix(line.p, line.q, t);
    let depth = mix(line.depth.x, line.depth.y, t);
    if !is_outline || !is_behind(at, depth) {
        return is_behind(at, depth);
    }
    let span = line.q - line.p;
    let aside = vec2(-span.y, span.x) * (BESIDE / max(length(span), 1e-6));
    return is_behind(at - aside, depth) && is_behind(at + aside, depth);
}

// How much of a pixel's length at `along` pixels from the edge's start lies on a dash; the first one has the edge's cap.
fn dash_at(along: f32) -> f32 {
    let pattern = DASH * max(style.line_width, 1.5);
    let place = along - floor(along / (pattern.x + pattern.y)) * (pattern.x + pattern.y);
    let from_start = select(place, pattern.x, along < pattern.x);
    return clamp(min(from_start, pattern.x - place) + 0.5, 0.0, 1.0);
}

// The strength that distance leaves at the part t of a segment, from 0 to 1.
fn strength_in_sight(line: Segment, t: f32) -> f32 {
    if !is_cued {
        return style.strength;
    }
    return style.strength * (1.0 - style.cue.w * farness_at(line, t));
}

// The strength at the part t of a segment, from 0 to 1, less where a face hides it.
fn strength_at(line: Segment, t: f32) -> f32 {
    let strength = strength_in_sight(line, t);
    if hidden == HIDDEN_SHOW {
        return strength;
    }
    if !is_hidden(line, t) {
        return strength;
    }
    if hidden == HIDDEN_DASH {
        return strength * dash_at(t * distance(line.p, line.q));
    }
    return select(0.0, PALE * strength, hidden == HIDDEN_FADE);
}
