// Planes among the depths of faces: where neighbouring pixels see one plane, what is under it is hidden however little
// it is under it. The depths that hide lines are biased so that faces hide no edge of their own, and of two faces a
// less steep one may so come before a nearer one; planes are found among the nearest depths as they are.
// Entry declares: tile, face_depths.
#import tile
#import triangle_setup

const FLAT_TOLERANCE_PX = 0.05; // of a pixel's width along the view and of the slope: what lies as near is on the plane
const COLLINEAR_TOLERANCE_PX = 0.02; // the same for depths in a row
const ON_AXIS_PX = 0.02; // what is nearer to the line between two centres is on it

fn nearest_depth(pixel: vec2<i32>) -> f32 {
    return bitcast<f32>(face_depths[n_depths(tile) + depth_index(tile, pixel)]);
}

// How much the depth rises from the pixel before one to it, and from it to the one after.
fn rises_across(pixel: vec2<i32>, depth: f32, step: vec2<i32>) -> vec2<f32> {
    return vec2(depth - nearest_depth(pixel - step), nearest_depth(pixel + step) - depth);
}

// Beside a border the larger change leads to another face.
fn smaller(rises: vec2<f32>) -> f32 {
    return select(rises.x, rises.y, abs(rises.y) < abs(rises.x));
}

// Whether a point is under a flat face. The centres of two pixels, with the point between them, and of a third must see
// one plane: a face hides nothing beside it, and so no edge of its own, however steep it is.
fn is_under_flat(at: vec2<f32>, depth: f32) -> bool {
    let pixel = vec2<i32>(floor(at));
    let offset = at - vec2<f32>(pixel) - 0.5;
    let towards = select(vec2(-1), vec2(1), offset > vec2(0.0));
    let is_along_x = abs(offset.x) > abs(offset.y);
    let step = select(vec2(0, towards.y), vec2(towards.x, 0), is_along_x);
    let aside = select(vec2(towards.x, 0), vec2(0, towards.y), is_along_x);
    let here = nearest_depth(pixel);
    let next = nearest_depth(pixel + step);
    if here == 0.0 || next == 0.0 {
        return false;
    }
    let change = next - here;
    let pixel_depth = tile.depth_slope_per_pixel.x * here + tile.depth_slope_per_pixel.y;
    let scale = pixel_depth + abs(change);
    let after = nearest_depth(pixel + 2 * step) - next;
    let before = here - nearest_depth(pixel - step);
    if min(abs(after - change), abs(before - change)) > COLLINEAR_TOLERANCE_PX * scale {
        return false;
    }
    let rises_aside = rises_across(pixel, here, aside);
    let slope_aside = smaller(rises_aside);
    if abs(slope_aside - smaller(rises_across(pixel + step, next, aside))) > COLLINEAR_TOLERANCE_PX * scale {
        return false; // two planes whose depths happen to be in line
    }
    if abs(change) + abs(slope_aside) > MAX_FLAT_SLOPE * pixel_depth {
        return false;
    }
    let distances = select(abs(offset.yx), abs(offset), is_along_x); // along and aside
    let is_aside = distances.y > ON_AXIS_PX;
    if is_aside && abs(rises_aside.x - rises_aside.y) > COLLINEAR_TOLERANCE_PX * (scale + abs(slope_aside)) {
        return false;
    }
    let plane = here + change * distances.x + slope_aside * distances.y;
    return depth < plane - FLAT_TOLERANCE_PX * (scale + abs(slope_aside));
}
