// Composites dots over the picture, as opaque together as their absorbance says. The nearest dot of a pixel takes what
// it leaves no light through by itself; the second one takes the rest.
#import absorbance
#import composite
#import destination
#import splat
#import tile
#import tile_cover

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<uniform> splat: Splat;
@group(0) @binding(2) var<storage, read> dots: array<PixelDots>;
@group(0) @binding(3) var<storage, read> dot_colors: array<vec2<u32>>;
@group(0) @binding(4) var destination: texture_2d<f32>; // premultiplied

override has_order: bool; // pixels keep their nearest dots
override absorbance_steps_per_e: f32;
override is_first: bool; // nothing has been drawn yet: the background is the destination

@vertex
fn vertex_main(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return tile_corner(vertex);
}

fn color_at(pixel: u32) -> vec4<f32> {
    let here = dots[pixel];
    let alpha = alpha_of(here.absorbance, absorbance_steps_per_e);
    if !has_order {
        return premultiply(vec4(splat.color.rgb, 1.0), alpha);
    }
    let colors = dot_colors[pixel];
    let first = unpack4x8unorm(colors.x);
    let second = unpack4x8unorm(colors.y);
    let share = select(min(alpha, first.a), alpha, here.depths.y == 0u);
    return vec4(first.rgb * share + second.rgb * (alpha - share), alpha);
}

@fragment
fn fragment_main(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let pixel = pixel_index(tile, tile.origin + vec2<i32>(position.xy));
    return composite_over(color_at(pixel), destination_at(position));
}
