// The loads and stores of transform_points and nothing else: the device's own bound on it, for benchmarks.
@group(0) @binding(0) var<storage, read> source: array<Vec4>;
@group(0) @binding(1) var<storage, read_write> destination: array<Vec4>;

override workgroup_size: u32;

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let i = 3u * invocation.x;
    let a = source[i];
    let b = source[i + 1u];
    let c = source[i + 2u];
    destination[i] = a;
    destination[i + 1u] = b;
    destination[i + 2u] = c;
}
