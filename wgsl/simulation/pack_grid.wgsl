// The state of a grid's points, from one texel per point to blocks of four columns.
#import grid_springs
#import texel

@group(0) @binding(0) var<uniform> grid: GridSprings;
@group(0) @binding(1) var state: texture_storage_2d<rgba32float, read>;
@group(0) @binding(2) var<storage, read_write> grid_positions: array<f32>; // x, y and z of the rows of a block
@group(0) @binding(3) var<storage, read_write> grid_velocities: array<f32>;

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
    let x = textureLoad(state, position_texel(point));
    let v = textureLoad(state, velocity_texel(point));
    grid_positions[at] = x.x;
    grid_positions[at + 4u] = x.y;
    grid_positions[at + 8u] = x.z;
    grid_velocities[at] = v.x;
    grid_velocities[at + 4u] = v.y;
    grid_velocities[at + 8u] = v.z;
}
