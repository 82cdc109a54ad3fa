// Visibility: what a face leaves in a pixel of the visibility buffer. It is an id, counted from 1, or a colour's index,
// counted from 1, above the light that falls on the face if that differs from pixel to pixel, and below it the opacity
// that a depth cue leaves if one fades the faces.
// Entry declares: has_light, has_depth_cue.
const OPACITY_STEPS = 255.0;
const OPACITY_BITS = 8u;

fn push_share(value: u32, share: f32) -> u32 {
    return (value << OPACITY_BITS) | u32(share * OPACITY_STEPS + 0.5);
}

fn last_share(value: u32) -> f32 {
    return f32(value & ((1u << OPACITY_BITS) - 1u)) / OPACITY_STEPS;
}

// light, opacity: from 0 to 1.
fn pack_visibility(color_id: u32, light: f32, opacity: f32) -> u32 {
    var value = color_id;
    if has_light {
        value = push_share(value, light);
    }
    if has_depth_cue {
        value = push_share(value, opacity);
    }
    return value;
}

struct Visibility {
    color_id: u32,
    light: f32,
    opacity: f32,
}

fn unpack_visibility(packed: u32) -> Visibility {
    var value = packed;
    var light = 1.0;
    var opacity = 1.0;
    if has_depth_cue {
        opacity = last_share(value);
        value = value >> OPACITY_BITS;
    }
    if has_light {
        light = last_share(value);
        value = value >> OPACITY_BITS;
    }
    return Visibility(value, light, opacity);
}
