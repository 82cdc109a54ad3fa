// The loads and stores of transform_points.wgsl and nothing else: the device's own bound on it, for benchmarks.
#import real

@group(0) @binding(0) var<storage, read> source: array<Vec4>;
@group(0) @binding(1) var<storage, read_write> destination: array<Vec4>;

override workgroup_size: u32;
override n_components: u32; // of a point, 2 or 3
override n_matrices: u32 = 1; // 1 to 8 copies, one after the other

fn store(index: u32, a: Vec4, b: Vec4, c: Vec4) {
    let j = n_components * index;
    destination[j] = a;
    destination[j + 1u] = b;
    if n_components == 3u {
        destination[j + 2u] = c;
    }
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    let index = invocation.x;
    let i = n_components * index;
    let a = source[i];
    let b = source[i + 1u];
    var c = Vec4();
    if n_components == 3u {
        c = source[i + 2u];
    }
    let n_packets = workgroup_size * n_workgroups.x;
    store(index, a, b, c);
    if n_matrices > 1u { store(index + n_packets, a, b, c); }
    if n_matrices > 2u { store(index + 2u * n_packets, a, b, c); }
    if n_matrices > 3u { store(index + 3u * n_packets, a, b, c); }
    if n_matrices > 4u { store(index + 4u * n_packets, a, b, c); }
    if n_matrices > 5u { store(index + 5u * n_packets, a, b, c); }
    if n_matrices > 6u { store(index + 6u * n_packets, a, b, c); }
    if n_matrices > 7u { store(index + 7u * n_packets, a, b, c); }
}
