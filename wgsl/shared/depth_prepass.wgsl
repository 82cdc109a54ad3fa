// Triangles to depths, and, when all depths are known, to the visibility buffer. Both times through the same pipelines:
// others might round otherwise, and no face would be as near as the nearest.
// Entry declares: tile, faces, clip_positions, triangles, face_depths, visibility, color_indices, corner_normals,
//     has_visibility, writes_ids, has_light, has_flats, has_depth_cue.
#import depth_cue
#import octahedral
#import tile
#import triangle_setup
#import uniform_flag
#import visibility

struct Faces {
    depth_cue: DepthCue,
    n_triangles: u32, // of each instance
    instance_stride: u32, // points from one instance to the next in the clip positions
    first_id: u32, // of a triangle's ids or of its colours' indices, whichever the visibility buffer holds
    writes_visibility: u32, // the second time, when all depths are known
    // From normals of the model to a frame whose z is towards the eye, its rows as columns; 0 without corner normals.
    light_from_normals: mat3x4<f32>,
}

const COPLANAR_FACTOR = 1.0 + 1e-6; // faces in one plane are rounded apart
const MAX_BANDS = 16u; // of a large triangle, that workgroups take side by side

// How many pixels across and down a workgroup takes at once.
fn block_size(workgroup_size: u32) -> vec2<u32> {
    let width = min(workgroup_size, 16u);
    return vec2(width, workgroup_size / width);
}

// The triangle with an index in its instance.
fn load_triangle(index: u32, instance: u32) -> Triangle {
    let corner = 3u * index;
    let first = faces.instance_stride * instance;
    return setup_triangle(
        clip_positions[first + triangles[corner]],
        clip_positions[first + triangles[corner + 1u]],
        clip_positions[first + triangles[corner + 2u]],
        tile,
    );
}

fn normal_to_eye(corner: u32) -> vec3<f32> {
    let normal = unpack_octahedral(corner_normals[min(corner, arrayLength(&corner_normals) - 1u)]);
    return vec4(normal, 0.0) * faces.light_from_normals;
}

// The normals at a triangle's corners, as columns, in a frame whose z is towards the eye; only for what reads them.
fn corner_normals_to_eye(index: u32) -> mat3x3<f32> {
    if !has_light || !is_set(faces.writes_visibility, index) {
        return mat3x3<f32>();
    }
    let corner = 3u * index;
    return mat3x3(normal_to_eye(corner), normal_to_eye(corner + 1u), normal_to_eye(corner + 2u));
}

// How far a triangle is turned to the eye in a pixel, 0 to 1. Corners count by their weights, of any sum.
fn light_at(normals: mat3x3<f32>, weights: vec3<f32>) -> f32 {
    let normal = normals * weights;
    let square = dot(normal, normal);
    return select(0.0, min(abs(normal.z) * inverseSqrt(square), 1.0), square > 0.0);
}

// Whether lines may be hidden by how near a triangle is in a pixel, and not only by how near it is by its bias. Steep
// ones come nearer by their margin alone.
fn is_flat(triangle: Triangle, fragment: TriangleFragment) -> bool {
    let pixel_depth = tile.depth_slope_per_pixel.x * fragment.depth + tile.depth_slope_per_pixel.y;
    return abs(triangle.depth.x) + abs(triangle.depth.y) <= MAX_FLAT_SLOPE * pixel_depth;
}

fn rasterize_pixel(triangle: Triangle, normals: mat3x3<f32>, index: u32, instance: u32, pixel: vec2<i32>) {
    let fragment = triangle_fragment(triangle, pixel, tile.depth_slope_per_pixel);
    let slot = depth_index(tile, pixel);
    if !has_visibility && !has_flats {
        // 0, which changes nothing, where it does not cover the pixel: what differs between neighbours is dear on
        // processors.
        atomicMax(&face_depths[slot], bitcast<u32>(fragment.biased_depth));
        return;
    }
    if !fragment.is_covered {
        return;
    }
    if !has_visibility || !is_set(faces.writes_visibility, index) {
        atomicMax(&face_depths[slot], bitcast<u32>(fragment.biased_depth));
        if has_flats && is_flat(triangle, fragment) {
            let depth = fragment.depth - dot(abs(fragment.weights), triangle.depth_error);
            atomicMax(&face_depths[slot + n_depths(tile)], bitcast<u32>(max(depth, 0.0)));
        }
        return;
    }
    if fragment.biased_depth * COPLANAR_FACTOR < bitcast<f32>(atomicLoad(&face_depths[slot])) {
        return;
    }
    if writes_ids {
        atomicMax(&visibility[slot], faces.first_id + instance * faces.n_triangles + index + 1u);
        return;
    }
    let color_index = color_indices[min(index, arrayLength(&color_indices) - 1u)];
    let color_id = faces.first_id + color_index + 1u;
    var light = 1.0;
    if has_light && any(faces.light_from_normals[2] != vec4(0.0)) {
        light = light_at(normals, fragment.weights);
    }
    var opacity = 1.0;
    if has_depth_cue {
        let cue = faces.depth_cue;
        let w = 1.0 / (fragment.weights.x + fragment.weights.y + fragment.weights.z);
        opacity = 1.0 - cue.amount * normalized_depth(cue, fragment.depth, w);
    }
    atomicMax(&visibility[slot], pack_visibility(color_id, light, opacity));
}
