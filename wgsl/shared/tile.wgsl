// A tile: the part of a picture that is drawn at once. All geometry is in pixels of the whole picture, so that a
// picture is the same whatever tiles it is split into.
struct Tile {
    size: vec2<f32>, // of the picture, pixels
    origin: vec2<i32>, // of the tile in the picture
    extent: vec2<i32>, // of the tile
    depth_origin: vec2<i32>, // of the part of the picture, larger than the tile, whose depths are known
    depth_extent: vec2<i32>,
    depth_slope_per_pixel: vec2<f32>, // over a pixel's width along the view, the depth d changes by x * d + y
    background: vec4<f32>, // premultiplied
}

// Clip space to pixels from the picture's top left corner: WebGPU's viewport transform.
fn clip_to_pixels(clip: vec4<f32>, size: vec2<f32>) -> vec2<f32> {
    return (clip.xy / clip.w * vec2(0.5, -0.5) + 0.5) * size;
}

// How many depths are known. Behind so many that are biased, and hide lines, lie as many as they are, if planes are
// looked for among them.
fn n_depths(tile: Tile) -> u32 {
    return u32(tile.depth_extent.x * tile.depth_extent.y);
}

fn n_pixels(tile: Tile) -> u32 {
    return u32(tile.extent.x * tile.extent.y);
}

// The index of a pixel in arrays over the tile.
fn pixel_index(tile: Tile, pixel: vec2<i32>) -> u32 {
    let offset = pixel - tile.origin;
    return u32(offset.y * tile.extent.x + offset.x);
}

// The pixel with an index in arrays over the tile.
fn pixel_at_index(tile: Tile, index: u32) -> vec2<i32> {
    let width = u32(tile.extent.x);
    return tile.origin + vec2(i32(index % width), i32(index / width));
}

// The index of a pixel, or of the nearest one whose depth is known, in arrays over those depths.
fn depth_index(tile: Tile, pixel: vec2<i32>) -> u32 {
    let offset = clamp(pixel - tile.depth_origin, vec2(0), tile.depth_extent - 1);
    return u32(offset.y * tile.depth_extent.x + offset.x);
}
