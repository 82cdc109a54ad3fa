// Compositing by Porter and Duff, "Compositing digital images", 1984: colours are premultiplied by their alpha.
fn premultiply(color: vec4<f32>, opacity: f32) -> vec4<f32> {
    let alpha = color.a * opacity;
    return vec4(color.rgb * alpha, alpha);
}

fn composite_over(source: vec4<f32>, destination: vec4<f32>) -> vec4<f32> {
    return source + destination * (1.0 - source.a);
}
