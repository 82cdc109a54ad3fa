// Small triangles, and slivers, row by row; large ones are listed.
// Entry declares: tile, faces, clip_positions, triangles, face_depths, visibility, color_indices, large_triangles,
//     corner_normals, workgroup_size, leaves_others, has_visibility, writes_ids, has_flats, has_light, has_depth_cue.
#import depth_prepass

struct LargeTriangles {
    n_workgroups: atomic<u32>, // three counts, as dispatch_workgroups_indirect reads them
    n_bands: atomic<u32>,
    n_layers: atomic<u32>,
    n_triangles: atomic<u32>,
    indices: array<u32>,
}

const MAX_SMALL_TRIANGLE_PX = 256; // in the bounding box
const MAX_SLIVER_PX = 2048; // in the rows of a long, thin triangle
const BOXES_PER_SLIVER = 4; // how many times as large its bounding box must be
const PIXELS_PER_BAND = 8192u; // a workgroup's own start costs about as much as a tenth of that
const MIN_WORKGROUPS = 64u; // side by side, if there are as many triangles
const MAX_WORKGROUPS = 65535u; // that WebGPU lets a dispatch have
const MAX_ROUNDS = 32768u; // per invocation: lavapipe stops loops after twice as many, without a word

// How many workgroups take `n` large triangles, each of which may be as large as the tile.
fn count_workgroups(n: u32) -> u32 {
    let blocks = vec2<u32>(tile.depth_extent) / block_size(workgroup_size) + 2u;
    let rounds = blocks.x * (blocks.y / MAX_BANDS + 1u) + 1u;
    let triangles_per_workgroup = max(MAX_ROUNDS / rounds, 1u);
    let needed = (n + triangles_per_workgroup - 1u) / triangles_per_workgroup;
    return min(max(min(n, MIN_WORKGROUPS), needed), MAX_WORKGROUPS);
}

fn defer_large(index: u32, n_pixels: i32) {
    let place = atomicAdd(&large_triangles.n_triangles, 1u);
    large_triangles.indices[place] = index;
    atomicMax(&large_triangles.n_workgroups, count_workgroups(place + 1u));
    atomicMax(&large_triangles.n_bands, clamp(u32(n_pixels) / PIXELS_PER_BAND, 1u, MAX_BANDS));
    atomicStore(&large_triangles.n_layers, 1u);
}

// Draws a triangle; returns whether it is left to others.
fn rasterize_small(index: u32, instance: u32) -> bool {
    let triangle = load_triangle(index, instance);
    if !triangle.is_valid {
        return false;
    }
    let extent = triangle.bbox_max - triangle.bbox_min + 1;
    let n_pixels = extent.x * extent.y;
    let is_small = n_pixels <= MAX_SMALL_TRIANGLE_PX;
    if leaves_others && !is_small {
        return true;
    }
    if !leaves_others && !is_small {
        let most = min(MAX_SLIVER_PX, n_pixels / BOXES_PER_SLIVER);
        var n_covered = 0;
        for (var y = triangle.bbox_min.y; y <= triangle.bbox_max.y && n_covered <= most; y++) {
            let columns = covered_columns(triangle, y);
            n_covered += max(columns.y - columns.x + 1, 0);
        }
        if n_covered > most {
            defer_large(instance * faces.n_triangles + index, n_pixels);
            return false;
        }
    }
    let normals = corner_normals_to_eye(index);
    var y = triangle.bbox_min.y;
    loop {
        var columns = vec2(triangle.bbox_min.x, triangle.bbox_max.x);
        if !leaves_others && !is_small {
            columns = covered_columns(triangle, y);
        }
        var x = columns.x;
        loop {
            if x <= columns.y {
                rasterize_pixel(triangle, normals, index, instance, vec2(x, y));
            }
            x++;
            if x > columns.y {
                break;
            }
        }
        y++;
        if y > triangle.bbox_max.y {
            break;
        }
    }
    return false;
}
