// Depths, or visibility, of large triangles: a workgroup takes a band of the bounding box of one, a block of pixels at
// a time.
#import depth_prepass

struct LargeTriangles {
    n_workgroups: u32, // three counts, as dispatch_workgroups_indirect reads them
    n_bands: u32,
    n_layers: u32,
    n_triangles: u32,
    indices: array<u32>,
}

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<uniform> faces: Faces;
@group(0) @binding(2) var<storage, read> clip_positions: array<vec4<f32>>; // reversed-Z
@group(0) @binding(3) var<storage, read> triangles: array<u32>; // three points each
@group(0) @binding(4) var<storage, read_write> face_depths: array<atomic<u32>>; // the nearest, as a float's bits
@group(0) @binding(5) var<storage, read_write> visibility: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read> color_indices: array<u32>; // one per triangle, or one for all
@group(0) @binding(7) var<storage, read> large_triangles: LargeTriangles; // from depth_small_triangles.wgsl
@group(0) @binding(8) var<storage, read> corner_normals: array<u32>; // three per triangle, octahedral

override workgroup_size: u32;
override has_visibility: bool; // there is a second time
override writes_ids: bool; // the visibility buffer holds ids of triangles, not indices of their colours
override has_flats: bool; // planes are looked for among the depths
override has_light: bool; // on some faces, that differs from pixel to pixel
override has_depth_cue: bool;

@compute @workgroup_size(workgroup_size)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) n_workgroups: vec3<u32>,
    @builtin(local_invocation_index) member: u32,
) {
    let block = block_size(workgroup_size);
    let step = vec2<i32>(block * vec2(1u, n_workgroups.y));
    let offset = vec2<i32>(vec2(member % block.x, workgroup.y * block.y + member / block.x));
    var i = workgroup.x;
    if i >= large_triangles.n_triangles {
        return;
    }
    loop {
        let index = large_triangles.indices[i] % faces.n_triangles;
        let instance = large_triangles.indices[i] / faces.n_triangles;
        let triangle = load_triangle(index, instance);
        let normals = corner_normals_to_eye(index);
        let start = triangle.bbox_min + offset;
        var y = start.y;
        loop {
            let columns = covered_columns(triangle, y);
            let n_before = max(columns.x - start.x, 0) / step.x;
            var x = start.x + n_before * step.x;
            loop {
                if x <= columns.y && y <= triangle.bbox_max.y {
                    rasterize_pixel(triangle, normals, index, instance, vec2(x, y));
                }
                x += step.x;
                if x > columns.y {
                    break;
                }
            }
            y += step.y;
            if y > triangle.bbox_max.y {
                break;
            }
        }
        i += n_workgroups.x;
        if i >= large_triangles.n_triangles {
            break;
        }
    }
}
