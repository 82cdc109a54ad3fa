// Several leapfrog steps of equal strands: an invocation goes down a strand once. A step is a front on its way down,
// two points behind the step before it, whose results it takes over in registers.
#import spring_step
#import grid_springs
#import obstacle
#import texel

@group(0) @binding(0) var<uniform> spring_step: SpringStep;
@group(0) @binding(1) var<uniform> grid: GridSprings;
@group(0) @binding(2) var<uniform> obstacles: array<Obstacle, MAX_OBSTACLES>;
@group(0) @binding(3) var state: texture_storage_2d<rgba32float, read>;
@group(0) @binding(4) var next_state: texture_storage_2d<rgba32float, write>;

override workgroup_size: u32;
override n_steps: u32; // up to four
override n_obstacles: u32;
override has_damping: bool;

const TINY = 1e-30; // m^2, so that a point that is not there divides by no zero

struct Point {
    x: vec4<f32>, // w: 1 / mass, 0 for pins
    v: vec4<f32>, // w: steps of the frame
}

struct Front {
    own: Point,
    after: Point,
    force: vec3<f32>, // on `own`, from the points before it
    force_after: vec3<f32>,
}

// The force with which a spring pulls `a` to `b`.
fn pull(a: Point, b: Point, spring: vec2<f32>) -> vec3<f32> {
    let d = b.x.xyz - a.x.xyz;
    let inverse_length = inverseSqrt(max(dot(d, d), TINY));
    var tension = spring.x - spring.y * inverse_length;
    if has_damping {
        let rate = dot(d, b.v.xyz - a.v.xyz) * inverse_length * inverse_length;
        tension += spring_step.damping_s * spring.x * rate;
    }
    return tension * d;
}

fn kick_and_drift(point: Point, force: vec3<f32>) -> Point {
    let is_free = point.x.w > 0.0;
    let drag = spring_step.drag_rate * (spring_step.wind - point.v.xyz);
    let kick = spring_step.kick_s * (point.x.w * force + spring_step.gravity + drag);
    var velocity = point.v.xyz + select(vec3<f32>(), kick, is_free);
    var position = point.x.xyz + spring_step.drift_s * velocity;
    let n_done = point.v.w + 1.0;
    if n_obstacles > 0u && is_free {
        var particle = Particle(position, velocity);
        for (var k = 0u; k < n_obstacles; k++) {
            particle = collide(k, n_done * spring_step.frame_part, spring_step.drift_s, particle);
        }
        position = particle.position;
        velocity = particle.velocity;
    }
    return Point(vec4(position, point.x.w), vec4(velocity, n_done));
}

// Let a front go on by one point: `row` is the number of its own, `after2` is the next but one. Returns the own after
// the step.
fn advance(front: ptr<function, Front>, after2: Point, row: i32) -> Point {
    let is_row = row >= 0;
    let has_after = f32(is_row && row + 1 < i32(grid.height));
    let has_after2 = f32(is_row && row + 2 < i32(grid.height));
    let down = has_after * pull((*front).own, (*front).after, grid.along_column);
    let down2 = has_after2 * pull((*front).own, after2, grid.over_column);
    let moved = kick_and_drift((*front).own, (*front).force + down + down2);
    let force_after = (*front).force_after - down;
    *front = Front((*front).after, after2, force_after, -down2);
    return moved;
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let strand = invocation.x;
    if strand >= grid.width {
        return;
    }
    let root = strand * grid.column_shift;
    var first: Front;
    var second: Front;
    var third: Front;
    var fourth: Front;
    let n_ticks = grid.height + 2u * n_steps;
    for (var tick = 0u; tick < n_ticks; tick++) {
        let row = i32(tick);
        let at = root + min(tick, grid.height - 1u) * grid.row_shift;
        var point = Point(textureLoad(state, position_texel(at)), textureLoad(state, velocity_texel(at)));
        point.v.w = select(point.v.w, 0.0, spring_step.is_first != 0u);
        point = advance(&first, point, row - 2);
        if n_steps > 1u {
            point = advance(&second, point, row - 4);
        }
        if n_steps > 2u {
            point = advance(&third, point, row - 6);
        }
        if n_steps > 3u {
            point = advance(&fourth, point, row - 8);
        }
        if tick >= 2u * n_steps {
            let done = root + (tick - 2u * n_steps) * grid.row_shift;
            textureStore(next_state, position_texel(done), point.x);
            textureStore(next_state, velocity_texel(done), point.v);
        }
    }
}
