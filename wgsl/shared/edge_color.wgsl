// The colour of a point of an edge.
// Entry declares: style, edges, colors, color_mode.
#import clip_segment
#import line_style

// At the part t of the segment of an edge, straight alpha.
fn color_at(index: u32, line: Segment, t: f32) -> vec4<f32> {
    if color_mode == COLOR_UNIFORM {
        return style.color;
    }
    if color_mode == COLOR_PER_EDGE {
        return unpack4x8unorm(colors[index]);
    }
    let t_clip = t_clip_at(line, t);
    let first = unpack4x8unorm(colors[edges[index].x]);
    let second = unpack4x8unorm(colors[edges[index].y]);
    // Weighted by alpha: what is transparent has no hue to mix in.
    let weights = vec2(1.0 - t_clip, t_clip) * vec2(first.a, second.a);
    let alpha = weights.x + weights.y;
    return vec4((weights.x * first.rgb + weights.y * second.rgb) / max(alpha, 1e-6), alpha);
}
