// Child strands between three guides each: one point per invocation.
@group(0) @binding(0) var<storage, read> children: array<vec4<u32>>; // guides, length; then two weights, clump: as f32
@group(0) @binding(1) var<storage, read> guides: array<vec4<f32>>; // points, strand by strand
@group(0) @binding(2) var<storage, read_write> points: array<f32>; // three per point

override workgroup_size: u32;
override n_points: u32; // of a strand, 2 or more

// The point of a guide at `at` segments from its root.
fn guide_point(strand: u32, at: f32) -> vec3<f32> {
    let k = min(u32(at), n_points - 2u);
    let first = strand * n_points + k;
    return mix(guides[first].xyz, guides[first + 1u].xyz, at - f32(k));
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let i = invocation.x;
    let child = i / n_points;
    if 2u * child >= arrayLength(&children) {
        return;
    }
    let head = children[2u * child];
    let tail = bitcast<vec4<f32>>(children[2u * child + 1u]);
    let k = f32(i % n_points);
    let fraction = k / f32(n_points - 1u);
    let weights = mix(vec3(tail.xy, 1.0 - tail.x - tail.y), vec3(1.0, 0.0, 0.0), tail.z * fraction * fraction);
    let at = bitcast<f32>(head.w) * k;
    let point = weights.x * guide_point(head.x, at) + weights.y * guide_point(head.y, at)
        + weights.z * guide_point(head.z, at);
    points[3u * i] = point.x;
    points[3u * i + 1u] = point.y;
    points[3u * i + 2u] = point.z;
}
