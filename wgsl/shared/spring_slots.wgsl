// Where the springs of a point are found: slots, four to a packet, of which each point uses some.
const MAX_PACKETS = 8u; // of slots that are alike for all points

const SLOTS_LISTED = 0u; // each slot of each point holds an end, a rest length and a stiffness of its own
const SLOTS_ALIKE = 1u; // a slot holds springs of one rest length and one stiffness, and each point's other end
const SLOTS_SHIFTED = 2u; // besides, the other end is the same number of points ahead

struct SlotPacket {
    rest: vec4<f32>, // m
    stiffness: vec4<f32>, // N/m
    shift: vec4<i32>, // points
}
