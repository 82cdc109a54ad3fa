// Composites lines of one colour over the picture, as opaque as their absorbance says.
#import absorbance
#import composite
#import destination
#import line_cover
#import line_style
#import tile

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<uniform> style: LineStyle;
@group(0) @binding(2) var<storage, read> clip_positions: array<vec4<f32>>; // reversed-Z
@group(0) @binding(3) var<storage, read> edges: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read> absorbance: array<u32>; // from accumulate_lines.wgsl
@group(0) @binding(5) var destination: texture_2d<f32>; // premultiplied

override absorbance_steps_per_e: f32;
override covers_edges: bool; // a quad over each edge is drawn, not one triangle over the tile
override is_instanced: bool; // there is more than one instance
override is_first: bool; // nothing has been drawn yet: the background is the destination

@vertex
fn vertex_main(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return line_cover_vertex(vertex);
}

@fragment
fn fragment_main(@builtin(position) position: vec4<f32>) -> @location(0) vec4<f32> {
    let index = pixel_index(tile, tile.origin + vec2<i32>(position.xy));
    let source = premultiply(vec4(style.color.rgb, 1.0), alpha_of(absorbance[index], absorbance_steps_per_e));
    return composite_over(source, destination_at(position));
}
