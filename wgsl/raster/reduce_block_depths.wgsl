// The depth of each block of pixels: dots behind it change none of its pixels any more. That of a pixel is the depth of
// its second dot if it is opaque, because nothing behind two dots is seen then. The next batch begins in the list of
// points where the last one ended.
#import absorbance
#import splat
#import tile

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<storage, read> dots: array<PixelDots>;
@group(0) @binding(2) var<storage, read_write> block_depths: array<u32>; // as the bits of floats

@group(0) @binding(3) var<storage, read_write> list: PointList;

override workgroup_size: u32;
override has_order: bool; // pixels keep their nearest dots
override absorbance_steps_per_e: f32;

fn depth_of(pixel: PixelDots) -> u32 {
    if pixel.absorbance < opaque_absorbance(absorbance_steps_per_e) {
        return 0u;
    }
    return select(0xffffffffu, pixel.depths.y, has_order);
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    if invocation.x == 0u {
        list.first = list.end;
    }
    let n_across = blocks_across(tile.extent.x);
    let n_blocks = n_across * blocks_across(tile.extent.y);
    var block = invocation.x;
    if block >= n_blocks {
        return;
    }
    loop {
        let first = BLOCK_SIDE * vec2<i32>(vec2(block % n_across, block / n_across));
        var depth = 0xffffffffu;
        for (var i = 0; i < BLOCK_SIDE * BLOCK_SIDE; i++) {
            let pixel = min(first + vec2(i % BLOCK_SIDE, i / BLOCK_SIDE), tile.extent - 1);
            depth = min(depth, depth_of(dots[pixel.y * tile.extent.x + pixel.x]));
        }
        block_depths[block] = depth;
        block += n_workgroups.x * workgroup_size;
        if block >= n_blocks {
            break;
        }
    }
}
