// Composites lines of one colour over the target, as opaque as their absorbance says.
#import absorbance
#import composite
#import line_style
#import tile

struct TouchedPixels {
    n: u32,
    indices: array<u32>,
}

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<uniform> style: LineStyle;
@group(0) @binding(2) var<storage, read> absorbance: array<u32>; // from accumulate_lines.wgsl
@group(0) @binding(3) var<storage, read> touched_pixels: TouchedPixels;
@group(0) @binding(4) var<storage, read_write> render_target: array<u32>; // of the tile, premultiplied

override workgroup_size: u32;
override absorbance_steps_per_e: f32;
override is_listed: bool; // the pixels with absorbance are few, and listed in touched_pixels
override is_first: bool = false; // nothing has been drawn yet, not even the background

// The next pixel with absorbance, from an index on; what lies before it becomes background if nothing has been drawn
// yet.
fn next_touched(first: u32, n: u32, stride: u32, background: u32) -> u32 {
    var index = first;
    while index < n && absorbance[index] == 0u {
        if is_first {
            render_target[index] = background;
        }
        index += stride;
    }
    return index;
}

fn composite_pixel(index: u32) {
    let source = premultiply(vec4(style.color.rgb, 1.0), alpha_of(absorbance[index], absorbance_steps_per_e));
    let destination = select(unpack4x8unorm(render_target[index]), tile.background, is_first);
    render_target[index] = pack4x8unorm(composite_over(source, destination));
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    let stride = n_workgroups.x * workgroup_size;
    if is_listed {
        let n_touched = touched_pixels.n;
        for (var i = invocation.x; i < n_touched; i += stride) {
            composite_pixel(touched_pixels.indices[i]);
        }
        return;
    }
    let n = n_pixels(tile);
    let background = pack4x8unorm(tile.background);
    var index = invocation.x;
    loop {
        // Each invocation looks for its next pixel first: on a CPU, masked work costs as much as work that is done.
        index = next_touched(index, n, stride, background);
        if index >= n {
            break;
        }
        composite_pixel(index);
        index += stride;
    }
}
