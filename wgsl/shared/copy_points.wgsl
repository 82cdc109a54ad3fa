// The loads and stores of transform_points and nothing else: the device's own bound on it, for benchmarks.
@group(0) @binding(0) var<storage, read> source: array<Vec4>;
@group(0) @binding(1) var<storage, read_write> destination: array<Vec4>;

override workgroup_size: u32;
override n_rows: u32 = 1; // 1 to 8 copies, one after the other

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    let i = 3u * invocation.x;
    let quad = array(source[i], source[i + 1u], source[i + 2u]);
    let row_length = 3u * workgroup_size * n_workgroups.x;
    put(i, quad);
    if n_rows > 1u { put(i + row_length, quad); }
    if n_rows > 2u { put(i + 2u * row_length, quad); }
    if n_rows > 3u { put(i + 3u * row_length, quad); }
    if n_rows > 4u { put(i + 4u * row_length, quad); }
    if n_rows > 5u { put(i + 5u * row_length, quad); }
    if n_rows > 6u { put(i + 6u * row_length, quad); }
    if n_rows > 7u { put(i + 7u * row_length, quad); }
}

fn put(j: u32, quad: array<Vec4, 3>) {
    destination[j] = quad[0];
    destination[j + 1u] = quad[1];
    destination[j + 2u] = quad[2];
}
