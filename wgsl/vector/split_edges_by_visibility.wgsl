// Edges to spans that are wholly visible or wholly hidden, for vector pictures: counted first, then written. One
// pipeline does both: another might round otherwise, and write another number of spans than was counted.
#import dash_start
#import dda
#import line_opacity
#import line_style
#import load_segment
#import tile
#import uniform_flag

struct Span {
    ends: vec4<f32>, // pixels, in the edge's direction
    edge: u32, // counted over all instances
    is_hidden: u32,
    t_clip: f32, // of the edge in clip space, at the span's centre
    opacity: f32, // that distance leaves there
    start_px: f32, // along its chain, where the span begins; as in dash_start.wgsl
    normalized_depth: f32, // of the span's centre
}

struct CountOrWrite {
    is_writing: u32, // not counting
    first: u32, // of all spans, the one that `spans` begins with, which may not hold all
}

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<uniform> style: LineStyle;
@group(0) @binding(2) var<storage, read> clip_positions: array<vec4<f32>>; // reversed-Z
@group(0) @binding(3) var<storage, read> edges: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> face_depths: array<u32>; // bits of floats, which order as the floats do
@group(0) @binding(5) var<storage, read_write> span_counts: array<u32>; // per edge; when writing, of the edges before
@group(0) @binding(6) var<storage, read_write> spans: array<Span>;
@group(0) @binding(7) var<uniform> count_or_write: CountOrWrite;
@group(0) @binding(8) var<storage, read> dash_starts: array<f32>; // of the edges of all instances

override workgroup_size: u32;
override hidden: u32; // one of HIDDEN_*
override dashes: u32; // one of DASHES_*
override is_silhouette: bool;
override has_flats: bool;
override has_depth_cue: bool;
override max_span_px: f32; // along the major axis

fn write_span(line: Segment, axis: MajorAxis, edge: u32, place: u32, begin: f32, end: f32, is_covered: bool) {
    let index = span_counts[edge] + place - count_or_write.first; // far beyond the end for those before the first
    if !is_set(count_or_write.is_writing, edge) || index >= arrayLength(&spans) {
        return;
    }
    let range = select(vec2(begin, end), vec2(1.0 - end, 1.0 - begin), axis.is_reversed);
    let center = 0.5 * (range.x + range.y);
    spans[index] = Span(
        vec4(mix(line.p, line.q, range.x), mix(line.p, line.q, range.y)),
        edge,
        u32(is_covered),
        t_clip_at(line, center),
        cued_opacity_at(line, center),
        line.dash_start + range.x * distance(line.p, line.q),
        normalized_depth_at(line, center, style.depth_cue),
    );
}

fn split(index: u32, instance: u32) {
    let edge = instance * style.n_edges + index;
    var line = load_segment(index, instance, 0.5 * style.line_width + 1.0);
    line.dash_start = dash_start_of(edge);
    var n_spans = 0u;
    if line.is_valid {
        let axis = major_axis(line);
        let bounds = bounds_in_tile(axis, tile);
        let first = clamp(i32(floor(axis.start.x)), bounds.x, bounds.y);
        let last = clamp(i32(ceil(axis.start.x + axis.length_major)), first + 1, bounds.y + 1) - 1;
        var begin = 0.0;
        var state = false;
        for (var x = first; x <= last; x++) {
            let is_covered = hidden != HIDDEN_SHOW && is_hidden(line, t_at_column(axis, x));
            if x == first {
                state = is_covered;
            }
            let at = (f32(x) - axis.start.x) / axis.length_major;
            if x > first && (is_covered != state || (at - begin) * axis.length_major >= max_span_px) {
                write_span(line, axis, edge, n_spans, begin, at, state);
                n_spans++;
                begin = at;
                state = is_covered;
            }
        }
        write_span(line, axis, edge, n_spans, begin, 1.0, state);
        n_spans++;
    }
    if !is_set(count_or_write.is_writing, edge) {
        span_counts[edge] = n_spans;
    }
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    var index = invocation.x;
    if index >= style.n_edges {
        return;
    }
    loop {
        split(index, invocation.y);
        index += n_workgroups.x * workgroup_size;
        if index >= style.n_edges {
            break;
        }
    }
}
