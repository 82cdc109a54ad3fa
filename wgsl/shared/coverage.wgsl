// How much of a pixel lies under a line: the pixel is a unit square, the line a capsule.
#import dda

override is_wide: bool; // what holds of a line is asked for each pixel across, not once for each step along

// Straight outwards from the line, its rim lies this far to the left above, to the right below.
fn rim_lean(way: Walk, half_width: f32) -> f32 {
    return half_width * way.slope * inverseSqrt(1.0 + way.slope * way.slope);
}

// A step of a walk, cut into four strips most nearly across the line, and where the capsule's rim cuts them off.
struct Strips {
    bottom: vec4<f32>, // across
    top: vec4<f32>,
    width: f32, // of each; 0 where the capsule has ended
}

fn strips_at(way: Walk, half_width: f32, lean: f32, x: i32) -> Strips {
    let left = f32(x) - way.start.x;
    let first = max(left, -half_width);
    let last = min(left + 1.0, way.run + half_width);
    let width = 0.25 * max(last - first, 0.0);
    let at = first + width * vec4(0.5, 1.5, 2.5, 3.5);
    // The points of the line whose circles touch the rim above and below `at`.
    let foot_above = clamp(at + lean, vec4(0.0), vec4(way.run));
    let foot_below = clamp(at - lean, vec4(0.0), vec4(way.run));
    let top = way.start.y + way.slope * foot_above + rise(half_width, at - foot_above);
    let bottom = way.start.y + way.slope * foot_below - rise(half_width, at - foot_below);
    return Strips(bottom, top, width);
}

// How far a circle's rim lies from its middle's height, at some distance from its middle.
fn rise(radius: f32, distance: vec4<f32>) -> vec4<f32> {
    return sqrt(max(radius * radius - distance * distance, vec4(0.0)));
}

// The first and the last pixel of a step that the capsule touches.
fn rows_of(strips: Strips) -> vec2<i32> {
    let bottom = min(strips.bottom.xy, strips.bottom.zw);
    let top = max(strips.top.xy, strips.top.zw);
    return vec2(i32(floor(min(bottom.x, bottom.y))), i32(floor(max(top.x, top.y))));
}

// The part of the pixel `y` across under the capsule: within a twenty-fifth everywhere and a hundredth beside the line.
fn coverage(strips: Strips, y: i32) -> f32 {
    let row = vec4(f32(y));
    let heights = max(min(strips.top, row + 1.0) - max(strips.bottom, row), vec4(0.0));
    return strips.width * (heights.x + heights.y + heights.z + heights.w);
}
