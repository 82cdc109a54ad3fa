// Composites filled faces over the picture, in the colours that the visibility buffer names.
#import composite
#import destination
#import tile
#import tile_cover
#import visibility

const AMBIENT = 0.3; // of a face's colour, that one seen edge-on keeps

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<storage, read> visibility: array<u32>;
@group(0) @binding(2) var<storage, read> palette: array<u32>; // straight alpha
@group(0) @binding(3) var destination: texture_2d<f32>; // premultiplied

override has_light: bool;
override has_depth_cue: bool;
override is_first: bool; // nothing has been drawn yet: the background is the destination

@vertex
fn vertex_main(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return tile_corner(vertex);
}

fn color_at(pixel: vec2<i32>) -> vec4<f32> {
    let value = visibility[depth_index(tile, pixel)];
    let seen = unpack_visibility(value);
    var color = unpack4x8unorm(palette[max(seen.color_id, 1u) - 1u]);
    if has_light {
        color = vec4(color.rgb * mix(AMBIENT, 1.0, seen.light), color.a);
    }
    return premultiply(color, select(0.0, seen.opacity, value != 0u));
}

@fragment
fn fragment_main(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    return composite_over(color_at(tile.origin + vec2<i32>(position.xy)), destination_at(position));
}
