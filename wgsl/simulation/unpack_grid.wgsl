// The state of a grid's points, from blocks of four columns back to one texel per point.
#import grid_springs
#import texel

@group(0) @binding(0) var<uniform> grid: GridSprings;
@group(0) @binding(1) var<storage, read> grid_positions: array<f32>; // x, y and z of the rows of a block
@group(0) @binding(2) var<storage, read> grid_velocities: array<f32>;
@group(0) @binding(3) var<storage, read> inverse_masses: array<f32>; // 1/kg, of the rows of a block
@group(0) @binding(4) var state: texture_storage_2d<rgba32float, write>;

override workgroup_size: u32;

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let row = invocation.x / grid.width;
    let column = invocation.x % grid.width;
    if row >= grid.height {
        return;
    }
    let point = row * grid.row_shift + column * grid.column_shift;
    let block_row = (column / 4u + 1u) * grid.n_padded_rows + row + 2u;
    let at = 12u * block_row + column % 4u;
    let x = vec3(grid_positions[at], grid_positions[at + 4u], grid_positions[at + 8u]);
    let v = vec3(grid_velocities[at], grid_velocities[at + 4u], grid_velocities[at + 8u]);
    let inverse_mass = inverse_masses[4u * block_row + column % 4u];
    textureStore(state, position_texel(point), vec4(x, inverse_mass));
    textureStore(state, velocity_texel(point), vec4(v, 0.0));
}
