// Depths, or visibility, of the triangles that depth_small_triangles.wgsl has left, if they are not large.
#import depth_prepass
#import small_triangles

struct TriangleList {
    n_workgroups: u32, // three counts, as dispatch_workgroups_indirect reads them
    n_workgroups_y: u32,
    n_workgroups_z: u32,
    n_triangles: u32,
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
@group(0) @binding(9) var<storage, read> left_triangles: TriangleList;

override workgroup_size: u32;
override leaves_others: bool; // false
override has_visibility: bool; // there is a second time
override writes_ids: bool; // the visibility buffer holds ids of triangles, not indices of their colours
override has_flats: bool; // planes are looked for among the depths
override has_light: bool; // on some faces, that differs from pixel to pixel
override has_depth_cue: bool;

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    let n = left_triangles.n_triangles;
    var i = invocation.x;
    if i >= n {
        return;
    }
    loop {
        let index = left_triangles.indices[i];
        rasterize_small(index % faces.n_triangles, index / faces.n_triangles);
        i += n_workgroups.x * workgroup_size;
        if i >= n {
            break;
        }
    }
}
