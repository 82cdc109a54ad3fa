// How far along its chain each edge begins in the picture, so that dashes run on from edge to edge. Chains are cut into
// sections of as many edges: a first dispatch adds up the lengths in each, a second one those of the sections before.
#import clip_segment
#import line_style
#import tile

struct ChainEdge {
    edge: u32, // with the flags below
    start: u32, // the points as the chain passes them, so that no edge is looked up: those that follow one another are
    end: u32, // seldom neighbours in memory
}

struct SectionEnd {
    length_px: f32, // from the section's start, or from the last chain that begins in it
    begins_chain: u32,
}

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<uniform> style: LineStyle;
@group(0) @binding(2) var<storage, read> clip_positions: array<vec4<f32>>; // reversed-Z
@group(0) @binding(3) var<storage, read> chains: array<ChainEdge>;
@group(0) @binding(4) var<storage, read_write> dash_starts: array<f32>; // as dash_start.wgsl says
@group(0) @binding(5) var<storage, read_write> section_ends: array<SectionEnd>;

override workgroup_size: u32;
override is_adding: bool; // the second dispatch

const EDGES_PER_SECTION = 64u;
const CHAIN_IS_FIRST = 0x80000000u;
const CHAIN_IS_REVERSED = 0x40000000u;
const CHAIN_EDGE_MASK = 0x3fffffffu;

fn begins_chain(place: u32) -> bool {
    return (chains[place].edge & CHAIN_IS_FIRST) != 0u;
}

fn length_in_picture(a: vec4<f32>, b: vec4<f32>) -> f32 {
    if is_in_view(a) && is_in_view(b) {
        return distance(clip_to_pixels(a, tile.size), clip_to_pixels(b, tile.size));
    }
    let line = clip_segment(a, b, 0.5 * style.line_width + 1.0, tile.size);
    return select(0.0, distance(line.p, line.q), line.is_valid);
}

fn end_of(section: u32) -> u32 {
    return min((section + 1u) * EDGES_PER_SECTION, style.n_edges);
}

fn measure(section: u32, instance: u32, n_sections: u32) {
    var end = SectionEnd(0.0, 0u);
    let first = instance * style.instance_stride;
    var last = NO_POINT; // where the edge before ends: most begin there, and points are far apart in memory
    var last_position = vec4(0.0);
    var place = section * EDGES_PER_SECTION;
    let last_place = end_of(section) - 1u;
    loop {
        let entry = chains[place];
        if (entry.edge & CHAIN_IS_FIRST) != 0u {
            end = SectionEnd(0.0, 1u);
        }
        let slot = instance * style.n_edges + (entry.edge & CHAIN_EDGE_MASK);
        let start_px = end.length_px;
        if entry.start != NO_POINT {
            var position = last_position;
            if entry.start != last {
                position = clip_positions[first + entry.start];
            }
            last = entry.end;
            last_position = clip_positions[first + last];
            end.length_px += length_in_picture(position, last_position);
        }
        dash_starts[slot] = select(start_px, -end.length_px, (entry.edge & CHAIN_IS_REVERSED) != 0u);
        if place == last_place {
            break;
        }
        place++;
    }
    section_ends[instance * n_sections + section] = end;
}

fn add_sections_before(section: u32, instance: u32, n_sections: u32) {
    if begins_chain(section * EDGES_PER_SECTION) {
        return;
    }
    // A chain is short enough for this loop: a driver ends long ones.
    var before = section;
    var length_px = 0.0;
    loop {
        before--;
        let end = section_ends[instance * n_sections + before];
        length_px += end.length_px;
        if end.begins_chain != 0u || before == 0u {
            break;
        }
    }
    var place = section * EDGES_PER_SECTION;
    let last_place = end_of(section) - 1u;
    var entry = chains[place].edge;
    loop {
        let slot = instance * style.n_edges + (entry & CHAIN_EDGE_MASK);
        dash_starts[slot] += select(length_px, -length_px, (entry & CHAIN_IS_REVERSED) != 0u);
        if place == last_place {
            break;
        }
        place++;
        entry = chains[place].edge;
        if (entry & CHAIN_IS_FIRST) != 0u {
            break;
        }
    }
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    let n_sections = (style.n_edges + EDGES_PER_SECTION - 1u) / EDGES_PER_SECTION;
    var section = invocation.x;
    if section >= n_sections {
        return;
    }
    loop {
        if is_adding {
            add_sections_before(section, invocation.y, n_sections);
        } else {
            measure(section, invocation.y, n_sections);
        }
        section += n_workgroups.x * workgroup_size;
        if section >= n_sections {
            break;
        }
    }
}
