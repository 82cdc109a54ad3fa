// Depths, or visibility, of small triangles, one per invocation; large ones are left to depth_large_triangles.wgsl. Of
// many triangles, all that are not small are left to depth_left_triangles.wgsl: slivers would hold up their neighbours.
#import depth_prepass
#import small_triangles

struct GrowingTriangleList {
    n_workgroups: atomic<u32>, // three counts, as dispatch_workgroups_indirect reads them
    n_workgroups_y: atomic<u32>,
    n_workgroups_z: atomic<u32>,
    n_triangles: atomic<u32>,
    indices: array<u32>, // over all instances
}

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<uniform> faces: Faces;
@group(0) @binding(2) var<storage, read> clip_positions: array<vec4<f32>>; // reversed-Z
@group(0) @binding(3) var<storage, read> triangles: array<u32>; // three points each
@group(0) @binding(4) var<storage, read_write> face_depths: array<atomic<u32>>; // the nearest, as a float's bits
@group(0) @binding(5) var<storage, read_write> visibility: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read> color_indices: array<u32>; // one per triangle, or one for all
@group(0) @binding(7) var<storage, read_write> large_triangles: LargeTriangles;
@group(0) @binding(8) var<storage, read> corner_normals: array<u32>; // three per triangle, octahedral
@group(0) @binding(9) var<storage, read_write> left_triangles: GrowingTriangleList; // as TriangleList

override workgroup_size: u32;
override leaves_others: bool; // that are not small
override has_visibility: bool; // there is a second time
override writes_ids: bool; // the visibility buffer holds ids of triangles, not indices of their colours
override has_flats: bool; // planes are looked for among the depths
override has_light: bool; // on some faces, that differs from pixel to pixel
override has_depth_cue: bool;

fn list_left(index: u32) {
    let place = atomicAdd(&left_triangles.n_triangles, 1u);
    left_triangles.indices[place] = index;
    atomicMax(&left_triangles.n_workgroups, min(place / workgroup_size + 1u, MAX_WORKGROUPS));
    atomicStore(&left_triangles.n_workgroups_y, 1u);
    atomicStore(&left_triangles.n_workgroups_z, 1u);
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    let n = faces.n_triangles;
    var i = invocation.x;
    if i >= n {
        return;
    }
    loop {
        if rasterize_small(i, invocation.y) {
            list_left(invocation.y * faces.n_triangles + i);
        }
        i += n_workgroups.x * workgroup_size;
        if i >= n {
            break;
        }
    }
}
