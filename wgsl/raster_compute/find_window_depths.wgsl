// The farthest depth in each cell, then, in a second dispatch, in each window.
#import depth_windows
#import tile

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<storage, read> depths: array<u32>; // of the pixels, or of the cells; bits of floats
@group(0) @binding(2) var<storage, read_write> farthest: array<u32>; // in the cells, or in the windows

override workgroup_size: u32;
override is_second: bool;

fn find_farthest(index: i32, n_across: i32) {
    let extent = select(tile.depth_extent, cell_counts(tile), is_second);
    let side = select(CELL_PX, 2, is_second);
    let first = select(CELL_PX, 1, is_second) * vec2(index % n_across, index / n_across);
    var depth = 0xffffffffu;
    var i = 0;
    loop {
        let at = min(first + vec2(i % side, i / side), extent - 1);
        depth = min(depth, depths[at.y * extent.x + at.x]);
        i++;
        if i == side * side {
            break;
        }
    }
    farthest[index] = depth;
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    let n_cells = cell_counts(tile);
    let n = u32(n_cells.x * n_cells.y);
    var i = invocation.x;
    if i >= n {
        return;
    }
    loop {
        find_farthest(i32(i), n_cells.x);
        i += n_workgroups.x * workgroup_size;
        if i >= n {
            break;
        }
    }
}
