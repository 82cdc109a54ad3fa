// Edges into pieces that are wholly visible or wholly hidden, for vector pictures: counted first, then written. One
// pipeline does both: another might round otherwise, and write another number of pieces than was counted.
#import dda
#import line_opacity
#import uniform_flag

struct Piece {
    ends: vec4<f32>, // pixels, in the edge's direction
    edge: u32, // counted over all instances
    is_hidden: u32,
    along: vec2<f32>, // of the edge in clip space, at the piece's middle; and what distance leaves of its strength there
    start: f32, // pixels along the segment, where the piece begins
    farness: f32, // of the piece's middle, as in depth_cue.wgsl
}

struct Turn {
    is_writing: u32, // not counting
    first: u32, // of all pieces, the one that `pieces` begins with, which may not hold all
}

@group(0) @binding(5) var<storage, read_write> counts: array<u32>; // of pieces, an edge; when writing, of those before
@group(0) @binding(6) var<storage, read_write> pieces: array<Piece>;
@group(0) @binding(7) var<uniform> turn: Turn;
override longest: f32; // pixels a piece may have along the axis it advances most on
override workgroup_size: u32;

fn put(line: Segment, way: Walk, edge: u32, place: u32, begin: f32, end: f32, is_covered: bool) {
    let index = counts[edge] + place - turn.first; // far beyond the end for those before the first
    if !is_asked(turn.is_writing, edge) || index >= arrayLength(&pieces) {
        return;
    }
    let part = select(vec2(begin, end), vec2(1.0 - end, 1.0 - begin), way.is_backward);
    let middle = 0.5 * (part.x + part.y);
    let weights = vec2(1.0 - middle, middle) * line.inverse_w;
    let along = mix(line.part.x, line.part.y, weights.y / (weights.x + weights.y));
    pieces[index] = Piece(
        vec4(mix(line.p, line.q, part.x), mix(line.p, line.q, part.y)),
        edge,
        u32(is_covered),
        vec2(along, strength_in_sight(line, middle)),
        part.x * distance(line.p, line.q),
        farness_at(line, middle),
    );
}

fn cut(index: u32, instance: u32) {
    let edge = instance * style.n_edges + index;
    let line = segment(edges[index], instance, 0.5 * style.line_width + 1.0);
    var n_pieces = 0u;
    if line.exists {
        let way = walk(line);
        let bounds = bounds_in_tile(way);
        let first = clamp(i32(floor(way.start.x)), bounds.x, bounds.y);
        let last = clamp(i32(ceil(way.start.x + way.run)), first + 1, bounds.y + 1) - 1;
        var begin = 0.0;
        var state = false;
        for (var x = first; x <= last; x++) {
            let t = part_at(way, x);
            let is_covered = hidden != HIDDEN_SHOW && is_hidden(line, t);
            if x == first {
                state = is_covered;
            }
            let at = (f32(x) - way.start.x) / way.run;
            if x > first && (is_covered != state || (at - begin) * way.run >= longest) {
                put(line, way, edge, n_pieces, begin, at, state);
                n_pieces++;
                begin = at;
                state = is_covered;
            }
        }
        put(line, way, edge, n_pieces, begin, 1.0, state);
        n_pieces++;
    }
    if !is_asked(turn.is_writing, edge) {
        counts[edge] = n_pieces;
    }
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    for (var index = invocation.x; index < style.n_edges; index += n_groups.x * workgroup_size) {
        cut(index, invocation.y);
    }
}
