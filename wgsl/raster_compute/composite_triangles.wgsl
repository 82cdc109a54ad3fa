// Composites filled faces over the target, in the colours that the visibility buffer names.
#import composite
#import tile
#import visibility

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<storage, read> visibility: array<u32>;
@group(0) @binding(2) var<storage, read> palette: array<u32>; // straight alpha
@group(0) @binding(3) var<storage, read_write> render_target: array<u32>; // of the tile, premultiplied

override workgroup_size: u32;
override has_depth_cue: bool;
override is_first: bool = false; // nothing has been drawn yet, not even the background

fn visibility_at(index: u32) -> u32 {
    return visibility[depth_index(tile, pixel_at_index(tile, index))];
}

// The next pixel with a face, from an index on; what lies before it becomes background if nothing has been drawn yet.
fn next_covered(first: u32, n: u32, stride: u32, background: u32) -> u32 {
    var index = first;
    while index < n && visibility_at(index) == 0u {
        if is_first {
            render_target[index] = background;
        }
        index += stride;
    }
    return index;
}

fn color_at(index: u32) -> vec4<f32> {
    let value = visibility_at(index);
    if !has_depth_cue {
        return premultiply(unpack4x8unorm(palette[value - 1u]), 1.0);
    }
    return premultiply(unpack4x8unorm(palette[unpack_color_id(value) - 1u]), unpack_opacity(value));
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    let stride = n_workgroups.x * workgroup_size;
    let n = n_pixels(tile);
    let background = pack4x8unorm(tile.background);
    var index = invocation.x;
    loop {
        // Each invocation looks for its next pixel first: on a CPU, masked work costs as much as work that is done.
        index = next_covered(index, n, stride, background);
        if index >= n {
            break;
        }
        let destination = select(unpack4x8unorm(render_target[index]), tile.background, is_first);
        render_target[index] = pack4x8unorm(composite_over(color_at(index), destination));
        index += stride;
    }
}
