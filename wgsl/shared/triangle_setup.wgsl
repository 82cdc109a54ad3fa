// A triangle in the picture, by homogeneous edge functions: nothing is cut at the eye's plane, and pixels are the same
// however the picture is tiled. Olano and Greer, "Triangle scan conversion using 2D homogeneous coordinates", 1997.
#import tile
#import depth_cue
#import visibility
#import uniform_flag

struct Faces {
    cue: vec4<f32>, // what distance leaves of their colours, as in depth_cue.wgsl
    n_triangles: u32,
    n_points: u32, // of one instance in `projected`, padding included
    first_mark: u32,
    is_marking: u32, // the second time round, when all depths are known
}

@group(0) @binding(1) var<uniform> faces: Faces;
@group(0) @binding(2) var<storage, read> projected: array<vec4<f32>>; // clip space, depth 1 at the near plane
@group(0) @binding(3) var<storage, read> triangles: array<u32>; // three points each
@group(0) @binding(4) var<storage, read_write> face_depths: array<atomic<u32>>; // the nearest, as a float's bits
@group(0) @binding(5) var<storage, read_write> face_marks: array<atomic<u32>>; // as in visibility.wgsl
@group(0) @binding(6) var<storage, read> triangle_colors: array<u32>; // the colour's place, one a triangle or one for all
override numbered: bool; // marks are the triangles' numbers, not their colours' places
override workgroup_size: u32;

const MOST_BANDS = 16u; // of a large triangle, that workgroups go through side by side
const RIM = 0.01; // pixels by which a triangle is larger, so that none falls between two
const NEARLY = 1.0 + 1e-6; // faces in one plane are rounded apart
const BIAS = 0.25; // of a pixel's width along the view: for other faces about a corner

struct Triangle {
    inside: mat3x3<f32>, // columns: each edge's function of (x, y, 1) less `anchor`
    rim: vec3<f32>,
    depth: vec3<f32>,
    bias: f32,
    unsure: vec3<f32>, // of the depth, times w, at each corner
    anchor: vec2<i32>,
    low: vec2<i32>, // pixels
    high: vec2<i32>,
    exists: bool,
}

// How many pixels across and down a workgroup takes at once.
fn block() -> vec2<u32> {
    let width = min(workgroup_size, 16u);
    return vec2(width, workgroup_size / width);
}

fn in_picture(clip: vec4<f32>) -> vec3<f32> {
    return vec3((clip.xy * vec2(0.5, -0.5) + 0.5 * clip.w) * tile.size, clip.w);
}

// Whether what reaches behind the eye lies before the near plane, or beside the tile by a pixel. Else it may be seen
// anywhere: a hull of what its corners are in the picture is not known. The columns are their x, y and w.
fn is_elsewhere(corners: mat3x3<f32>, depth: vec3<f32>) -> bool {
    let x = corners[0];
    let y = corners[1];
    let w = corners[2];
    let first = vec2<f32>(tile.depth_origin) - 1.0;
    let last = vec2<f32>(tile.depth_origin + tile.depth_extent) + 1.0;
    return all(depth > w)
        || all(x < first.x * w) || all(x > last.x * w)
        || all(y < first.y * w) || all(y > last.y * w);
}

fn triangle(index: u32) -> Triangle {
    var out: Triangle;
    let corner = 3u * (index % faces.n_triangles);
    let first = faces.n_points * (index / faces.n_triangles);
    let a = projected[first + triangles[corner]];
    let b = projected[first + triangles[corner + 1u]];
    let c = projected[first + triangles[corner + 2u]];
    let w = vec3(a.w, b.w, c.w);
    if all(w <= vec3(0.0)) {
        return out;
    }
    out.low = tile.depth_origin;
    out.high = tile.depth_origin + tile.depth_extent - 1;
    if all(w > vec3(0.0)) {
        let p = to_pixels(a);
        let q = to_pixels(b);
        let r = to_pixels(c);
        // Only pixels whose middle lies in the triangle are touched.
        let lowest = ceil(min(min(p, q), r) - 0.5 - RIM);
        let highest = floor(max(max(p, q), r) - 0.5 + RIM);
        // Beside the picture too: there lies the axis of a wide line whose rim is seen.
        let first = vec2<f32>(out.low);
        let last = vec2<f32>(out.high);
        out.anchor = vec2<i32>(clamp(lowest, vec2(-1.0), tile.size));
        out.low = vec2<i32>(clamp(lowest, first, last + 1.0));
        out.high = vec2<i32>(clamp(highest, first - 1.0, last));
    } else if is_elsewhere(transpose(mat3x3(in_picture(a), in_picture(b), in_picture(c))), vec3(a.z, b.z, c.z)) {
        return out;
    }
    if any(out.high < out.low) {
        return out;
    }
    // Relative to a pixel close by, because single precision squares coordinates here.
    let anchor = vec3(vec2<f32>(out.anchor), 0.0);
    let u = in_picture(a) - anchor * a.w;
    let v = in_picture(b) - anchor * b.w;
    let t = in_picture(c) - anchor * c.w;
    let inside = mat3x3(cross(v, t), cross(t, u), cross(u, v));
    let volume = dot(u, inside[0]);
    if volume == 0.0 {
        return out;
    }
    out.inside = inside * (1.0 / volume);
    out.rim = RIM * vec3(length(out.inside[0].xy), length(out.inside[1].xy), length(out.inside[2].xy));
    // In a slender triangle what rounding leaves of a small difference counts for its whole length: taken off once.
    let corners = mat3x3(u, v, t);
    let z = vec3(a.z, b.z, c.z);
    let rough = out.inside * z;
    out.depth = rough + out.inside * (z - rough * corners);
    out.unsure = abs(z - out.depth * corners);
    // A line is tested up to half a pixel beside the pixel's middle.
    out.bias = 0.5 * (abs(out.depth.x) + abs(out.depth.y));
    out.exists = true;
    return out;
}

fn touch_pixel(face: Triangle, index: u32, pixel: vec2<i32>) {
    let middle = vec3(vec2<f32>(pixel - face.anchor) + 0.5, 1.0);
    let depth = dot(face.depth, middle);
    let shares = middle * face.inside; // of the corners, divided by w
    if any(shares < -face.rim) || depth < 0.0 || depth > 1.0 {
        return;
    }
    let slot = depth_index(pixel);
    let bias = face.bias + dot(abs(shares), face.unsure) + BIAS * (tile.pixel_depth.x * depth + tile.pixel_depth.y);
    let pushed = max(depth - bias, 0.0);
    if !is_asked(faces.is_marking, index) {
        atomicMax(&face_depths[slot], bitcast<u32>(pushed));
        return;
    }
    if pushed * NEARLY < bitcast<f32>(atomicLoad(&face_depths[slot])) {
        return;
    }
    if numbered {
        atomicMax(&face_marks[slot], faces.first_mark + index + 1u);
    } else {
        let color = triangle_colors[min(index % faces.n_triangles, arrayLength(&triangle_colors) - 1u)];
        let left = 1.0 - faces.cue.w * farness(faces.cue, depth, 1.0 / (shares.x + shares.y + shares.z));
        atomicMax(&face_marks[slot], mark_of(faces.first_mark + color + 1u, left));
    }
}
