// The state of a grid's points, from one vector per point to blocks of four columns, or back.
#import grid_springs

@group(0) @binding(0) var<uniform> grid: GridSprings;
@group(0) @binding(1) var<storage, read_write> positions: array<vec4<f32>>; // w: 1 / mass, 0 for pins
@group(0) @binding(2) var<storage, read_write> velocities: array<vec4<f32>>; // w: steps of the frame
@group(0) @binding(3) var<storage, read_write> grid_positions: array<f32>; // x, y and z of the rows of a block
@group(0) @binding(4) var<storage, read_write> grid_velocities: array<f32>;

override workgroup_size: u32;
override is_packing: bool; // into blocks

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let row = invocation.x / grid.width;
    let column = invocation.x % grid.width;
    if row >= grid.height {
        return;
    }
    let point = row * grid.row_shift + column * grid.column_shift;
    let at = 12u * ((column / 4u + 1u) * grid.n_padded_rows + row + 2u) + column % 4u;
    if is_packing {
        let x = positions[point];
        let v = velocities[point];
        grid_positions[at] = x.x;
        grid_positions[at + 4u] = x.y;
        grid_positions[at + 8u] = x.z;
        grid_velocities[at] = v.x;
        grid_velocities[at + 4u] = v.y;
        grid_velocities[at + 8u] = v.z;
    } else {
        let w = positions[point].w;
        positions[point] = vec4(grid_positions[at], grid_positions[at + 4u], grid_positions[at + 8u], w);
        let v = vec3(grid_velocities[at], grid_velocities[at + 4u], grid_velocities[at + 8u]);
        velocities[point] = vec4(v, 0.0);
    }
}
