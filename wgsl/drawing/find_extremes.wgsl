// Points to the few that reach farthest: each invocation finds, among every so many-th packet of four, those at which
// linear functions of the coordinates are smallest and largest. Four functions make a group, as lanes of vectors.
struct ExtremesQuery {
    n_points: u32,
    offset: f32, // of the first function of all, which must be positive if only_positive
    groups: array<mat3x4<f32>, 3>, // columns are the factors of x, y and z
}

// What each invocation finds of a group; the indices of points are NOT_FOUND if no point counts.
struct Extremes {
    lowest: vec4<f32>,
    highest: vec4<f32>,
    lowest_at: vec4<u32>,
    highest_at: vec4<u32>,
}

const NOT_FOUND = 0xffffffffu;
const LARGEST = 3.4028234e38;

@group(0) @binding(0) var<uniform> query: ExtremesQuery;
@group(0) @binding(1) var<storage, read> points: array<vec4<f32>>; // packets of four points
@group(0) @binding(2) var<storage, read_write> extremes: array<Extremes>; // n_groups per invocation
@group(0) @binding(3) var<storage, read_write> n_non_finite: atomic<u32>; // points

override workgroup_size: u32;
override n_groups: u32; // 1 to 3
override only_positive: bool; // points count at which the first function is positive

var<private> found_0: Extremes; // of the first group
var<private> found_1: Extremes;
var<private> found_2: Extremes;
var<private> n_bad: u32;

fn is_finite(p: vec3<f32>) -> bool { // by bits: WGSL lets a compiler take it for granted that no number is infinite
    return all((bitcast<vec3<u32>>(p) & vec3(0x7f800000u)) != vec3(0x7f800000u));
}

fn visit_group(found: ptr<private, Extremes>, index: u32, value: vec4<f32>) {
    let is_lower = value < (*found).lowest;
    (*found).lowest = select((*found).lowest, value, is_lower);
    (*found).lowest_at = select((*found).lowest_at, vec4(index), is_lower);
    let is_higher = value > (*found).highest;
    (*found).highest = select((*found).highest, value, is_higher);
    (*found).highest_at = select((*found).highest_at, vec4(index), is_higher);
}

fn visit(index: u32, p: vec3<f32>) {
    if index >= query.n_points {
        return;
    }
    if !is_finite(p) {
        n_bad += 1u;
        return;
    }
    if only_positive && (query.groups[0] * p).x + query.offset <= 0.0 {
        return;
    }
    visit_group(&found_0, index, query.groups[0] * p);
    if n_groups > 1u {
        visit_group(&found_1, index, query.groups[1] * p);
    }
    if n_groups > 2u {
        visit_group(&found_2, index, query.groups[2] * p);
    }
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    found_0 = Extremes(vec4(LARGEST), vec4(-LARGEST), vec4(NOT_FOUND), vec4(NOT_FOUND));
    found_1 = found_0;
    found_2 = found_0;
    for (var i = invocation.x; 4u * i < query.n_points; i += n_workgroups.x * workgroup_size) {
        let a = points[3u * i];
        let b = points[3u * i + 1u];
        let c = points[3u * i + 2u];
        visit(4u * i, a.xyz);
        visit(4u * i + 1u, vec3(a.w, b.xy));
        visit(4u * i + 2u, vec3(b.zw, c.x));
        visit(4u * i + 3u, c.yzw);
    }
    let first = n_groups * invocation.x;
    extremes[first] = found_0;
    if n_groups > 1u {
        extremes[first + 1u] = found_1;
    }
    if n_groups > 2u {
        extremes[first + 2u] = found_2;
    }
    if n_bad > 0u {
        atomicAdd(&n_non_finite, n_bad);
    }
}
