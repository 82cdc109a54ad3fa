// Anti-aliased lines of any width and many colours, each over those before it: a quad around each edge, its pixels lit by
// how much of them the line covers.
#import coverage
#import strength
#import colors

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) ends: vec4<f32>, // pixels
    @location(1) @interpolate(flat) depth_and_w: vec4<f32>, // depths at the ends, inverses of w there
    @location(2) @interpolate(flat) part: vec2<f32>, // of the edge
    @location(3) @interpolate(flat) index: u32,
}

const PIXEL_RADIUS = 0.7072; // of a pixel's circumscribed circle

@vertex
fn vs_main(@builtin(vertex_index) corner: u32, @builtin(instance_index) copy: u32) -> Corner {
    var out: Corner;
    let index = copy % style.n_edges;
    let reach = 0.5 * style.line_width + PIXEL_RADIUS;
    let line = segment(edges[index], copy / style.n_edges, reach);
    if !line.exists {
        out.position = vec4(2.0, 2.0, 0.0, 1.0); // all four corners in one place, outside: no pixel
        return out;
    }
    let length_px = distance(line.p, line.q);
    let tangent = select(vec2(1.0, 0.0), (line.q - line.p) / length_px, length_px > 0.0);
    let normal = vec2(-tangent.y, tangent.x);
    let at_end = (corner & 1u) == 1u;
    let above = (corner & 2u) == 2u;
    let base = select(line.p - tangent * reach, line.q + tangent * reach, at_end);
    let pixel = base + normal * select(-reach, reach, above) - vec2<f32>(tile.origin);
    out.position = vec4((pixel / vec2<f32>(tile.extent) - 0.5) * vec2(2.0, -2.0), 0.0, 1.0);
    out.ends = vec4(line.p, line.q);
    out.depth_and_w = vec4(line.depth, line.inverse_w);
    out.part = line.part;
    out.index = index;
    return out;
}

@fragment
fn fs_main(in: Corner) -> @location(0) vec4<f32> {
    let pixel = in.position.xy + vec2<f32>(tile.origin);
    let line = Segment(in.ends.xy, in.ends.zw, in.depth_and_w.xy, in.depth_and_w.zw, in.part, true);
    let half_width = 0.5 * style.line_width;
    let way = walk(line);
    let step = vec2<i32>(floor(select(pixel, pixel.yx, way.is_steep)));
    let covered = coverage(strips_at(way, half_width, rim_lean(way, half_width), step.x), step.y);
    if covered <= 0.0 {
        discard;
    }
    let span = line.q - line.p;
    let t = select(0.0, clamp(dot(pixel - line.p, span) / dot(span, span), 0.0, 1.0), dot(span, span) > 0.0);
    let color = color_at(in.index, line, t);
    let alpha = color.a * covered * strength_at(line, t);
    return vec4(color.rgb * alpha, alpha); // premultiplied, as the blending expects
}
