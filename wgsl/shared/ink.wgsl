// Ink: the negative logarithm of what shines through, in whole steps, so that sums do not depend on their order.
const INK_STEPS = 2048.0; // for a factor of e
const LEAST_LIGHT = 4e-4; // a fifth of what eight bits show
const OPAQUE_INK = 16384u; // lets through less than that
const OVERFULL_INK = 0x80000000u;

fn ink_of(alpha: f32) -> u32 {
    return u32(-log(max(1.0 - alpha, LEAST_LIGHT)) * INK_STEPS + 0.5);
}

fn alpha_of(ink: u32) -> f32 {
    return select(1.0 - exp(-f32(ink) / INK_STEPS), 1.0, ink >= OPAQUE_INK);
}
