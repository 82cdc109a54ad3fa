// What colour a place of an edge has.
#import clip_segment

@group(0) @binding(6) var<storage, read> colors: array<u32>; // as color_mode says

override color_mode: u32; // what they belong to

const COLOR_UNIFORM = 0u;
const COLOR_PER_EDGE = 1u;
const COLOR_PER_VERTEX = 2u;

// The colour at the part t of a segment of the edge number `index`, straight alpha.
fn color_at(index: u32, line: Segment, t: f32) -> vec4<f32> {
    if color_mode == COLOR_UNIFORM {
        return style.color;
    }
    if color_mode == COLOR_PER_EDGE {
        return unpack4x8unorm(colors[index]);
    }
    // Even steps in the picture are not even along the edge: nearer parts look longer.
    let weights = vec2(1.0 - t, t) * line.inverse_w;
    let along = mix(line.part.x, line.part.y, weights.y / (weights.x + weights.y));
    let first = unpack4x8unorm(colors[edges[index].x]);
    let second = unpack4x8unorm(colors[edges[index].y]);
    // What is clear has no hue to mix in.
    let shares = vec2(1.0 - along, along) * vec2(first.a, second.a);
    let alpha = shares.x + shares.y;
    return vec4((shares.x * first.rgb + shares.y * second.rgb) / max(alpha, 1e-6), alpha);
}
