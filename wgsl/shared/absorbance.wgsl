// Absorbance: the negative logarithm of transmittance, in whole steps, so that sums do not depend on their order. The
// product of the transmittances of several lines is the sum of their absorbances.
const OPAQUE_ABSORBANCE = 8.0; // factors of e, from which on no light is seen

fn absorbance_of(alpha: f32, min_transmittance: f32, steps_per_e: f32) -> u32 {
    return u32(-log(max(1.0 - alpha, min_transmittance)) * steps_per_e + 0.5);
}

fn opaque_absorbance(steps_per_e: f32) -> u32 {
    return u32(OPAQUE_ABSORBANCE * steps_per_e);
}

fn alpha_of(absorbance: u32, steps_per_e: f32) -> f32 {
    return select(1.0 - exp(-f32(absorbance) / steps_per_e), 1.0, absorbance >= opaque_absorbance(steps_per_e));
}
