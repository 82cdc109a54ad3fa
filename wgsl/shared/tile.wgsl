// The part of a picture that is drawn at once. All geometry is in pixels of the whole picture, so that a picture is the
// same however it is cut.
struct Tile {
    size: vec2<f32>, // of the picture, pixels
    origin: vec2<i32>, // of the tile in the picture
    extent: vec2<i32>, // of the tile
    depth_origin: vec2<i32>, // of the part of the picture, somewhat larger than the tile, whose depths are known
    depth_extent: vec2<i32>,
    pixel_depth: vec2<f32>, // what the depth d changes by over a pixel's width along the view: x * d + y
    background: vec4<f32>, // premultiplied
}

@group(0) @binding(0) var<uniform> tile: Tile;

fn to_pixels(clip: vec4<f32>) -> vec2<f32> {
    return (clip.xy / clip.w * vec2(0.5, -0.5) + 0.5) * tile.size;
}

// The index of a pixel of the tile.
fn tile_index(pixel: vec2<i32>) -> u32 {
    let place = pixel - tile.origin;
    return u32(place.y * tile.extent.x + place.x);
}

// The index of the depth at a pixel, or at the nearest one whose depth is known.
fn depth_index(pixel: vec2<i32>) -> u32 {
    let place = clamp(pixel - tile.depth_origin, vec2(0), tile.depth_extent - 1);
    return u32(place.y * tile.depth_extent.x + place.x);
}
