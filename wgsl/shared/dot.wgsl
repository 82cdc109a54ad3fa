// A point in the picture, as a dot.
// Entry declares: tile, splat, block_depths, is_small.
#import splat
#import tile

struct Dot {
    center: vec2<f32>, // pixels
    depth: f32,
    w: f32,
    first: vec2<i32>, // pixels of the tile
    last: vec2<i32>,
    is_valid: bool,
}

fn project(point: vec4<f32>) -> Dot {
    let clip = splat.clip_from_points * point;
    var dot: Dot;
    dot.center = clip_to_pixels(clip, tile.size);
    dot.depth = clip.z / clip.w;
    dot.w = clip.w;
    let margin = 1.0 + 4.0 * (splat.radius + 1.0) / tile.size; // beyond it, pixels might not fit 32 bits
    let is_inside = clip.w > 0.0 && clip.z >= 0.0 && clip.z <= clip.w && all(abs(clip.xy) <= margin * clip.w);
    dot.first = max(vec2<i32>(floor(dot.center - splat.radius)), tile.origin);
    dot.last = min(vec2<i32>(floor(dot.center + splat.radius)), tile.origin + tile.extent - 1);
    dot.is_valid = is_inside && all(dot.first <= dot.last);
    return dot;
}

fn depth_bits(depth: f32) -> u32 {
    return max(bitcast<u32>(depth), 1u);
}

// Whether a dot may change a pixel: none of those behind the depths of all its blocks does.
fn may_be_seen(dot: Dot) -> bool {
    let n_across = blocks_across(tile.extent.x);
    let first = vec2<u32>(dot.first - tile.origin) / u32(BLOCK_SIDE);
    let last = vec2<u32>(dot.last - tile.origin) / u32(BLOCK_SIDE);
    let key = depth_bits(dot.depth);
    let upper = min(block_depths[first.y * n_across + first.x], block_depths[first.y * n_across + last.x]);
    let lower = min(block_depths[last.y * n_across + first.x], block_depths[last.y * n_across + last.x]);
    var is_seen = key >= min(upper, lower);
    if !is_small {
        for (var y = first.y; y <= last.y && !is_seen; y++) {
            for (var x = first.x; x <= last.x && !is_seen; x++) {
                is_seen = key >= block_depths[y * n_across + x];
            }
        }
    }
    return is_seen;
}
