// One leapfrog step of a regular grid of points joined by springs. An invocation goes down a strip of rows, four
// columns wide, and keeps the rows around in registers: it loads each point once, not once per spring.
#import spring_step
#import grid_springs
#import obstacle

@group(0) @binding(0) var<uniform> spring_step: SpringStep;
@group(0) @binding(1) var<uniform> grid: GridSprings;
@group(0) @binding(2) var<uniform> obstacles: array<Obstacle, MAX_OBSTACLES>;
@group(0) @binding(3) var<storage, read> inverse_masses: array<vec4<f32>>; // 1/kg, 0 for pins
@group(0) @binding(4) var<storage, read> positions: array<vec4<f32>>; // x, y and z of a row of a block
@group(0) @binding(5) var<storage, read> velocities: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read_write> next_positions: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> next_velocities: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read_write> step_counts: array<f32>; // of the frame, per invocation

override workgroup_size: u32;
override rows_per_strip: u32;
override n_obstacles: u32;
override has_damping: bool;

const TINY = 1e-30; // m^2, so that an empty column divides by no zero

struct Vectors {
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
}

struct Block {
    p: Vectors,
    v: Vectors,
}

struct Row {
    left: Block,
    own: Block,
    right: Block,
}

fn load_block(at: u32) -> Block {
    let p = Vectors(positions[at], positions[at + 1u], positions[at + 2u]);
    return Block(p, Vectors(velocities[at], velocities[at + 1u], velocities[at + 2u]));
}

fn load_row(at: u32) -> Row {
    let side = 3u * grid.n_padded_rows;
    return Row(load_block(at - side), load_block(at), load_block(at + side));
}

fn ahead1(a: Vectors, b: Vectors) -> Vectors {
    return Vectors(vec4(a.x.yzw, b.x.x), vec4(a.y.yzw, b.y.x), vec4(a.z.yzw, b.z.x));
}

fn ahead2(a: Vectors, b: Vectors) -> Vectors {
    return Vectors(vec4(a.x.zw, b.x.xy), vec4(a.y.zw, b.y.xy), vec4(a.z.zw, b.z.xy));
}

fn behind1(a: Vectors, b: Vectors) -> Vectors {
    return Vectors(vec4(a.x.w, b.x.xyz), vec4(a.y.w, b.y.xyz), vec4(a.z.w, b.z.xyz));
}

fn behind2(a: Vectors, b: Vectors) -> Vectors {
    return Vectors(vec4(a.x.zw, b.x.xy), vec4(a.y.zw, b.y.xy), vec4(a.z.zw, b.z.xy));
}

fn shift_ahead1(row: Row) -> Block {
    return Block(ahead1(row.own.p, row.right.p), ahead1(row.own.v, row.right.v));
}

fn shift_ahead2(row: Row) -> Block {
    return Block(ahead2(row.own.p, row.right.p), ahead2(row.own.v, row.right.v));
}

fn shift_behind1(row: Row) -> Block {
    return Block(behind1(row.left.p, row.own.p), behind1(row.left.v, row.own.v));
}

fn shift_behind2(row: Row) -> Block {
    return Block(behind2(row.left.p, row.own.p), behind2(row.left.v, row.own.v));
}

fn add(a: Vectors, b: Vectors) -> Vectors {
    return Vectors(a.x + b.x, a.y + b.y, a.z + b.z);
}

fn subtract(a: Vectors, b: Vectors) -> Vectors {
    return Vectors(a.x - b.x, a.y - b.y, a.z - b.z);
}

// The forces with which springs pull points `a` to points `b`, in the columns in which `is_there` is 1 and not 0.
fn pull(a: Block, b: Block, spring: vec2<f32>, is_there: vec4<f32>) -> Vectors {
    let d = subtract(b.p, a.p);
    let inverse_length = inverseSqrt(max(d.x * d.x + d.y * d.y + d.z * d.z, vec4(TINY)));
    var tension = spring.x - spring.y * inverse_length;
    if has_damping {
        let w = subtract(b.v, a.v);
        let rate = (d.x * w.x + d.y * w.y + d.z * w.z) * inverse_length * inverse_length;
        tension += spring_step.damping_s * spring.x * rate;
    }
    tension *= is_there;
    return Vectors(tension * d.x, tension * d.y, tension * d.z);
}

fn collide_with_all(position: vec3<f32>, velocity: vec3<f32>, time: f32) -> Particle {
    var particle = Particle(position, velocity);
    for (var k = 0u; k < n_obstacles; k++) {
        particle = collide(k, time, spring_step.drift_s, particle);
    }
    return particle;
}

fn collide_block(block: Block, time: f32) -> Block {
    let p = transpose(mat3x4(block.p.x, block.p.y, block.p.z));
    let v = transpose(mat3x4(block.v.x, block.v.y, block.v.z));
    let a = collide_with_all(p[0], v[0], time);
    let b = collide_with_all(p[1], v[1], time);
    let c = collide_with_all(p[2], v[2], time);
    let d = collide_with_all(p[3], v[3], time);
    let pushed = transpose(mat4x3(a.position, b.position, c.position, d.position));
    let slowed = transpose(mat4x3(a.velocity, b.velocity, c.velocity, d.velocity));
    return Block(
        Vectors(pushed[0], pushed[1], pushed[2]),
        Vectors(slowed[0], slowed[1], slowed[2]),
    );
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let block = invocation.x % grid.n_blocks;
    let strip = invocation.x / grid.n_blocks;
    if strip >= grid.n_strips {
        return;
    }
    let n_steps = select(step_counts[invocation.x], 0.0, spring_step.is_first != 0u) + 1.0;
    step_counts[invocation.x] = n_steps;

    let column = f32(4u * block) + vec4(0.0, 1.0, 2.0, 3.0);
    let last = vec4(f32(grid.width) - 1.0);
    let is_there = step(column, last);
    let has_right = step(column + 1.0, last);
    let has_right2 = step(column + 2.0, last);
    let has_left = is_there * step(vec4(1.0), column);
    let has_left2 = is_there * step(vec4(2.0), column);

    let height = f32(grid.height);
    var number = f32(strip * rows_per_strip) - 2.0;
    var at = 3u * ((block + 1u) * grid.n_padded_rows + strip * rows_per_strip);
    var before: Row; // of the first row above the strip nothing is stored: that it knows no row before does not matter
    var row = load_row(at);
    var after = load_row(at + 3u);
    var force: Vectors; // of the row, from the rows before it
    var force_after: Vectors;
    for (var k = 0u; k < rows_per_strip + 2u; k++) {
        let after2 = load_row(at + 6u);
        let is_row = f32(number >= 0.0 && number < height);
        let has_after = is_row * f32(number + 1.0 < height);
        let has_after2 = is_row * f32(number + 2.0 < height);

        let down = pull(row.own, after.own, grid.along_column, vec4(has_after));
        let down2 = pull(row.own, after2.own, grid.over_column, vec4(has_after2));
        force = add(force, add(down, down2));
        force_after = subtract(force_after, down);
        force = add(force, pull(row.own, shift_ahead1(row), grid.along_row, has_right));
        force = add(force, pull(row.own, shift_behind1(row), grid.along_row, has_left));
        force = add(force, pull(row.own, shift_ahead2(row), grid.over_row, has_right2));
        force = add(force, pull(row.own, shift_behind2(row), grid.over_row, has_left2));
        force = add(force, pull(row.own, shift_ahead1(after), grid.shear, has_after * has_right));
        force = add(force, pull(row.own, shift_behind1(after), grid.shear, has_after * has_left));
        let has_before = f32(number >= 1.0);
        force = add(force, pull(row.own, shift_ahead1(before), grid.shear, has_before * has_right));
        force = add(force, pull(row.own, shift_behind1(before), grid.shear, has_before * has_left));
        if k >= 2u {
            let w = inverse_masses[at / 3u];
            let is_free = sign(w); // of a pin and of an empty column the inverse mass is 0
            let kick = is_free * spring_step.kick_s;
            let v = row.own.v;
            let drag = spring_step.drag_rate;
            var next = row.own;
            next.v.x += kick * (w * force.x + spring_step.gravity.x - drag * (v.x - spring_step.wind.x));
            next.v.y += kick * (w * force.y + spring_step.gravity.y - drag * (v.y - spring_step.wind.y));
            next.v.z += kick * (w * force.z + spring_step.gravity.z - drag * (v.z - spring_step.wind.z));
            next.p.x += spring_step.drift_s * next.v.x;
            next.p.y += spring_step.drift_s * next.v.y;
            next.p.z += spring_step.drift_s * next.v.z;
            if n_obstacles > 0u {
                let free = collide_block(next, n_steps * spring_step.frame_part);
                let is_moved = w > vec4(0.0);
                next.p.x = select(next.p.x, free.p.x, is_moved);
                next.p.y = select(next.p.y, free.p.y, is_moved);
                next.p.z = select(next.p.z, free.p.z, is_moved);
                next.v.x = select(next.v.x, free.v.x, is_moved);
                next.v.y = select(next.v.y, free.v.y, is_moved);
                next.v.z = select(next.v.z, free.v.z, is_moved);
            }
            next_positions[at] = next.p.x;
            next_positions[at + 1u] = next.p.y;
            next_positions[at + 2u] = next.p.z;
            next_velocities[at] = next.v.x;
            next_velocities[at + 1u] = next.v.y;
            next_velocities[at + 2u] = next.v.z;
        }
        before = row;
        row = after;
        after = after2;
        force = force_after;
        force_after = Vectors(-down2.x, -down2.y, -down2.z);
        at += 3u;
        number += 1.0;
    }
}
