// Depths of small triangles, one an invocation; large ones are left to `lay_large_faces`.
#import triangle

@group(0) @binding(7) var<storage, read_write> large: array<atomic<u32>>; // how many, and which

const LARGE = 256; // pixels of the box around

fn lay(index: u32) {
    let face = triangle(index);
    if !face.exists {
        return;
    }
    let extent = face.high - face.low + 1;
    if extent.x * extent.y > LARGE {
        atomicStore(&large[atomicAdd(&large[0], 1u) + 1u], index);
        return;
    }
    for (var y = face.low.y; y <= face.high.y; y++) {
        for (var x = face.low.x; x <= face.high.x; x++) {
            touch_pixel(face, index, vec2(x, y));
        }
    }
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    for (var i = invocation.x; i < faces.n_triangles; i += n_groups.x * workgroup_size) {
        lay(invocation.y * faces.n_triangles + i);
    }
}
