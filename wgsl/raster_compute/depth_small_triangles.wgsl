// Depths of small triangles, one an invocation; large ones are left to `lay_large_faces`.
#import triangle_setup

@group(0) @binding(7) var<storage, read_write> large: array<atomic<u32>>; // workgroups (x, y, z), how many, and which

const LARGE = 256; // pixels of the box around
const BAND = 8192u; // pixels; a workgroup's own start costs about as much as a tenth of that
const LEAST_GROUPS = 64u; // side by side, where there are as many triangles
const MOST_GROUPS = 65535u; // that WebGPU lets a dispatch have
const MOST_ROUNDS = 32768u; // of an invocation: lavapipe stops loops after twice as many, without a word

// How many workgroups take `n` large triangles, each of which may be as large as the tile.
fn groups_of(n: u32) -> u32 {
    let extent = vec2<u32>(tile.depth_extent);
    let blocks = extent / block() + 2u;
    let rounds = blocks.x * (blocks.y / MOST_BANDS + 1u) + 1u;
    let together = max(MOST_ROUNDS / rounds, 1u);
    return min(max(min(n, LEAST_GROUPS), (n + together - 1u) / together), MOST_GROUPS);
}

fn leave(index: u32, n_pixels: i32) {
    let place = atomicAdd(&large[3], 1u);
    atomicStore(&large[4u + place], index);
    atomicMax(&large[0], groups_of(place + 1u));
    atomicMax(&large[1], clamp(u32(n_pixels) / BAND, 1u, MOST_BANDS));
    atomicStore(&large[2], 1u);
}

fn lay(index: u32) {
    let face = triangle(index);
    if !face.exists {
        return;
    }
    let extent = face.high - face.low + 1;
    if extent.x * extent.y > LARGE {
        leave(index, extent.x * extent.y);
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
