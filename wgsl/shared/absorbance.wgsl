// Ink: the negative logarithm of what shines through, in whole steps, so that sums do not depend on their order.
override ink_steps: f32; // for a factor of e
override least_light: f32 = 1.0; // that a line lets through

const OPAQUE = 8.0; // the logarithm where no more light is seen

fn ink_of(alpha: f32) -> u32 {
    return u32(-log(max(1.0 - alpha, least_light)) * ink_steps + 0.5);
}

fn opaque_ink() -> u32 {
    return u32(OPAQUE * ink_steps);
}

fn alpha_of(ink: u32) -> f32 {
    return select(1.0 - exp(-f32(ink) / ink_steps), 1.0, ink >= opaque_ink());
}
