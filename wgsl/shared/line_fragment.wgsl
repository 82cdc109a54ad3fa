// What an anti-aliased line leaves in a pixel: absorbance, and, among lines of several colours, a depth key in the
// k-buffer.
// Entry declares: tile, style, edges, colors, absorbance, k_buffer, color_mode, has_transparency, k,
//     absorbance_steps_per_e, min_transmittance, may_overflow.
#import absorbance
#import clip_segment
#import depth_key
#import edge_color
#import edge_depth
#import line_style
#import tile

const SATURATED_ABSORBANCE = 0x80000000u; // far from the largest number, as others add at the same time

fn color_alpha_at(index: u32, line: Segment, t: f32) -> f32 {
    if color_mode == COLOR_UNIFORM {
        return style.color.a;
    }
    if !has_transparency {
        return 1.0;
    }
    return color_at(index, line, t).a;
}

// Keys come in any order: of those that come to a slot, all but the largest go on from it.
fn insert_key(slot: u32, key: u32) -> u32 {
    if key == 0u {
        return 0u;
    }
    return min(key, atomicMax(&k_buffer[slot], key));
}

fn accumulate_absorbance(pixel: u32, alpha: f32) {
    let amount = absorbance_of(alpha, min_transmittance, absorbance_steps_per_e);
    let before = atomicAdd(&absorbance[pixel], amount);
    if may_overflow && before > SATURATED_ABSORBANCE {
        atomicStore(&absorbance[pixel], opaque_absorbance(absorbance_steps_per_e));
    }
}

// Nothing is left of what has no alpha; it is better added, as 0, than left out: what differs between neighbours is
// dear on processors.
fn emit_fragment(pixel: vec2<i32>, alpha: f32, edge: u32, line: Segment) {
    let index = pixel_index(tile, pixel);
    accumulate_absorbance(index, alpha);
    if color_mode == COLOR_UNIFORM || alpha <= 0.0 {
        return;
    }
    let slots = k * index;
    let key = depth_key(ordering_depth_at(line, pixel, style.depth_cue), edge, style.edge_bits);
    let third = insert_key(slots + 1u, insert_key(slots, key)); // no loop: a driver ends long ones
    if k == 4u {
        insert_key(slots + 3u, insert_key(slots + 2u, third));
    }
}
