// The picture that fragments are composited over.
// Entry declares: tile, destination, is_first.
#import tile

// At a fragment's position, premultiplied. Textures of bytes are read as multiples of 1/255, rounded, and not as bytes
// divided by 255: what was drawn before would differ in its last bit from what was meant.
fn destination_at(position: vec4<f32>) -> vec4<f32> {
    if is_first {
        return tile.background;
    }
    return round(textureLoad(destination, vec2<i32>(position.xy), 0) * 255.0) / 255.0;
}
