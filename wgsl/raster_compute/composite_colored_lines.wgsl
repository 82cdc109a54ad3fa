// Lines of several colours over the picture. What the nearest edges let through of all ink has the last one's colour.
#import coverage
#import line_opacity
#import colors
#import depth_key
#import composite_listed

@group(0) @binding(8) var<storage, read> nearest: array<u32>; // as in accumulate_colored_lines.wgsl
override n_keys: u32;

fn line_of(key: u32) -> Segment {
    let edge = edge_of(key);
    return segment(edges[edge % style.n_edges], edge / style.n_edges, 0.5 * style.line_width + 1.0);
}

fn color_of(key: u32, pixel: vec2<i32>) -> vec4<f32> {
    let index = edge_of(key) % style.n_edges;
    if color_mode == COLOR_PER_EDGE {
        return unpack4x8unorm(colors[index]);
    }
    let line = line_of(key);
    return color_at(index, line, foot(line, pixel));
}

// How much of a pixel an edge leaves no light through by itself.
fn alpha_alone(key: u32, pixel: vec2<i32>) -> f32 {
    let line = line_of(key);
    let way = walk(line);
    let half_width = 0.5 * style.line_width;
    let step = select(pixel, pixel.yx, way.is_steep);
    let covered = coverage(strips_at(way, half_width, rim_lean(way, half_width), step.x), step.y);
    let t = select(part_at(way, step.x), foot(line, pixel), is_wide);
    return color_of(key, pixel).a * strength_at(line, t) * covered;
}

fn color_at_mark(place: u32) -> vec4<f32> {
    let alpha = alpha_of(ink[place]);
    let pixel = pixel_of(place);
    let keys = n_keys * place;
    var color = vec4(0.0);
    var key = nearest[keys];
    for (var i = 1u; key != 0u; i++) {
        // A CPU takes both ways of an `if`, but ends a loop that none of those in step goes on with.
        let next = select(0u, nearest[keys + min(i, n_keys - 1u)], i < n_keys);
        var share = alpha - color.a;
        for (var others = min(next, 1u); others > 0u; others--) {
            share = min(share, (1.0 - color.a) * alpha_alone(key, pixel));
        }
        color += vec4(color_of(key, pixel).rgb * share, share);
        key = next;
    }
    return color;
}
