// Pixels in the colours of the faces that marked them.
#import composite_marked
#import visibility

@group(0) @binding(5) var<storage, read> face_marks: array<u32>;
@group(0) @binding(6) var<storage, read> colors: array<u32>;

fn is_marked(index: u32) -> bool {
    return face_marks[depth_index(pixel_of(index))] != 0u;
}

fn color_at_mark(index: u32) -> vec4<f32> {
    let mark = face_marks[depth_index(pixel_of(index))];
    return premultiplied(unpack4x8unorm(colors[place_of(mark) - 1u]), left_of(mark));
}
