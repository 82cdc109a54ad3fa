// Triangle setup by homogeneous edge functions: nothing is clipped at the eye's plane, and pixels are the same whatever
// tiles the picture is split into. Olano and Greer, "Triangle scan conversion using 2D homogeneous coordinates", 1997.
#import tile

const CONSERVATIVE_MARGIN_PX = 0.01; // by which a triangle is larger, so that no pixel falls between two
const DEPTH_BIAS_PX = 0.25; // of a pixel's width along the view: for other faces about a corner
const MAX_FLAT_SLOPE = 6.0; // of planes, in pixels' widths per pixel: steeper ones are seen from their edges
const COLUMN_ERROR = 1e-5; // of an edge function, by the sizes of its terms: a hundred times single precision's

struct Triangle {
    edge_functions: mat3x3<f32>, // columns: each edge's function of (x, y, 1) less `origin`
    conservative_margin: vec3<f32>, // of the edge functions
    depth: vec3<f32>, // its coefficients of (x, y, 1) less `origin`
    depth_bias: f32,
    depth_error: vec3<f32>, // times w, at each corner
    origin: vec2<i32>,
    bbox_min: vec2<i32>, // pixels
    bbox_max: vec2<i32>,
    is_valid: bool,
}

// Clip space to homogeneous pixels: x and y times w, and w.
fn homogeneous_pixels(clip: vec4<f32>, size: vec2<f32>) -> vec3<f32> {
    return vec3((clip.xy * vec2(0.5, -0.5) + 0.5 * clip.w) * size, clip.w);
}

// Whether a triangle that reaches behind the eye lies before the near plane, or beside the tile by a pixel. Else it may
// be seen anywhere: its corners do not bound it. The columns are the x, y and w of the corners.
fn is_outside_tile(corners: mat3x3<f32>, depth: vec3<f32>, tile: Tile) -> bool {
    let x = corners[0];
    let y = corners[1];
    let w = corners[2];
    let first = vec2<f32>(tile.depth_origin) - 1.0;
    let last = vec2<f32>(tile.depth_origin + tile.depth_extent) + 1.0;
    return all(depth > w)
        || all(x < first.x * w) || all(x > last.x * w)
        || all(y < first.y * w) || all(y > last.y * w);
}

// The triangle between three points in clip space, where it may touch pixels whose depths are known.
fn setup_triangle(a: vec4<f32>, b: vec4<f32>, c: vec4<f32>, tile: Tile) -> Triangle {
    var triangle: Triangle;
    let w = vec3(a.w, b.w, c.w);
    if all(w <= vec3(0.0)) {
        return triangle;
    }
    let a_pixels = homogeneous_pixels(a, tile.size);
    let b_pixels = homogeneous_pixels(b, tile.size);
    let c_pixels = homogeneous_pixels(c, tile.size);
    let z = vec3(a.z, b.z, c.z);
    triangle.bbox_min = tile.depth_origin;
    triangle.bbox_max = tile.depth_origin + tile.depth_extent - 1;
    if all(w > vec3(0.0)) {
        let p = clip_to_pixels(a, tile.size);
        let q = clip_to_pixels(b, tile.size);
        let r = clip_to_pixels(c, tile.size);
        // Only pixels whose centre lies in the triangle are touched.
        let lowest = ceil(min(min(p, q), r) - 0.5 - CONSERVATIVE_MARGIN_PX);
        let highest = floor(max(max(p, q), r) - 0.5 + CONSERVATIVE_MARGIN_PX);
        // Beside the picture too: there lies the axis of a wide line whose edge is seen.
        let first = vec2<f32>(triangle.bbox_min);
        let last = vec2<f32>(triangle.bbox_max);
        triangle.origin = vec2<i32>(clamp(lowest, vec2(-1.0), tile.size));
        triangle.bbox_min = vec2<i32>(clamp(lowest, first, last + 1.0));
        triangle.bbox_max = vec2<i32>(clamp(highest, first - 1.0, last));
    } else if is_outside_tile(transpose(mat3x3(a_pixels, b_pixels, c_pixels)), z, tile) {
        return triangle;
    }
    if any(triangle.bbox_max < triangle.bbox_min) {
        return triangle;
    }
    // Relative to a pixel close by, because single precision squares coordinates here.
    let origin = vec3(vec2<f32>(triangle.origin), 0.0);
    let u = a_pixels - origin * a.w;
    let v = b_pixels - origin * b.w;
    let t = c_pixels - origin * c.w;
    let adjugate = mat3x3(cross(v, t), cross(t, u), cross(u, v));
    let determinant = dot(u, adjugate[0]);
    if determinant == 0.0 {
        return triangle;
    }
    triangle.edge_functions = adjugate * (1.0 / determinant);
    let slopes = vec3(
        length(triangle.edge_functions[0].xy),
        length(triangle.edge_functions[1].xy),
        length(triangle.edge_functions[2].xy),
    );
    triangle.conservative_margin = CONSERVATIVE_MARGIN_PX * slopes;
    // In a slender triangle what rounding leaves of a small difference counts for its whole length: taken off once.
    let corners = mat3x3(u, v, t);
    let rough = triangle.edge_functions * z;
    triangle.depth = rough + triangle.edge_functions * (z - rough * corners);
    triangle.depth_error = abs(z - triangle.depth * corners);
    // A line is tested up to half a pixel beside the pixel's centre.
    triangle.depth_bias = 0.5 * (abs(triangle.depth.x) + abs(triangle.depth.y));
    triangle.is_valid = true;
    return triangle;
}

// The first and the last column of a row that a triangle may cover, within its bounding box, and a pixel more on either
// side: a sliver covers little of its box.
fn covered_columns(triangle: Triangle, y: i32) -> vec2<i32> {
    let center_y = f32(y - triangle.origin.y) + 0.5;
    let box = vec2<f32>(vec2(triangle.bbox_min.x, triangle.bbox_max.x) - triangle.origin.x);
    let farthest = max(abs(box.x), abs(box.y)) + 1.0;
    var columns = box;
    for (var i = 0; i < 3; i++) {
        let edge = triangle.edge_functions[i];
        let sizes = abs(edge) * vec3(farthest, abs(center_y), 1.0);
        let margin = triangle.conservative_margin[i] + COLUMN_ERROR * dot(sizes, vec3(1.0));
        let at_zero = edge.y * center_y + edge.z + margin;
        let crossing = -at_zero / edge.x - 0.5;
        if edge.x > 0.0 {
            columns.x = max(columns.x, crossing - 1.0);
        } else if edge.x < 0.0 {
            columns.y = min(columns.y, crossing + 1.0);
        }
    }
    columns = clamp(columns, vec2(box.x - 1.0), vec2(box.y + 1.0));
    return triangle.origin.x + vec2(max(i32(floor(columns.x)), i32(box.x)), min(i32(ceil(columns.y)), i32(box.y)));
}

// What a triangle leaves in a pixel.
struct TriangleFragment {
    is_covered: bool,
    depth: f32,
    biased_depth: f32, // behind the triangle by all that its depth may be off
    weights: vec3<f32>, // of the corners, divided by w
}

fn triangle_fragment(triangle: Triangle, pixel: vec2<i32>, depth_slope_per_pixel: vec2<f32>) -> TriangleFragment {
    var fragment: TriangleFragment;
    let center = vec3(vec2<f32>(pixel - triangle.origin) + 0.5, 1.0);
    fragment.depth = dot(triangle.depth, center);
    fragment.weights = center * triangle.edge_functions;
    if any(fragment.weights < -triangle.conservative_margin) || fragment.depth < 0.0 || fragment.depth > 1.0 {
        return fragment;
    }
    let slope = depth_slope_per_pixel.x * fragment.depth + depth_slope_per_pixel.y;
    let bias = triangle.depth_bias + dot(abs(fragment.weights), triangle.depth_error) + DEPTH_BIAS_PX * slope;
    fragment.biased_depth = max(fragment.depth - bias, 0.0);
    fragment.is_covered = true;
    return fragment;
}
