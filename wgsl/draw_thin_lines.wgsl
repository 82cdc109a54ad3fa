// Edges to lines one pixel wide, as the device itself draws them: each pixel is on or off.
#import picture

struct End {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) color: vec4<f32>, // straight alpha
}

@vertex
fn vs_main(@builtin(vertex_index) end: u32) -> End {
    let edge = end / 2u;
    return End(projected[edges[edge][end % 2u]], edge_color(edge));
}

@fragment
fn fs_main(in: End) -> @location(0) vec4<f32> {
    return vec4(in.color.rgb * in.color.a, in.color.a); // premultiplied, as the blending expects
}
