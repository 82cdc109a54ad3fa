// Pixels in the colours of the edges that marked them, over the picture.
#import dda
#import line_opacity
#import colors
#import depth_key
#import composite_marked

override is_plain: bool; // all that is drawn looks the same
@group(0) @binding(5) var<storage, read> marks: array<u32>; // keys, or 1 where all looks the same

fn is_marked(index: u32) -> bool {
    return marks[index] != 0u;
}

fn color_at_mark(place: u32) -> vec4<f32> {
    if is_plain {
        return premultiplied(style.color, style.strength);
    }
    let edge = edge_of(marks[place]);
    let index = edge % style.n_edges;
    let line = segment(edges[index], edge / style.n_edges, 1.0);
    let way = walk(line);
    let pixel = pixel_of(place);
    let t = part_at(way, select(pixel.x, pixel.y, way.is_steep));
    return premultiplied(color_at(index, line, t), strength_at(line, t));
}
