// The colours of the nearest dots of each pixel follow their depths, where dots of another part of a cloud came nearer.
#import splat

@group(0) @binding(0) var<storage, read> dots_before: array<PixelDots>;
@group(0) @binding(1) var<storage, read> dots: array<PixelDots>;
@group(0) @binding(2) var<storage, read_write> dot_colors: array<vec2<u32>>;

override workgroup_size: u32;
override n_pixels: u32;

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    var pixel = invocation.x;
    if pixel >= n_pixels {
        return;
    }
    loop {
        let before = dots_before[pixel].depths;
        let depths = dots[pixel].depths;
        if any(depths != before) {
            let colors = dot_colors[pixel];
            let was_second = select(vec2(0u), vec2(colors.y), depths == vec2(before.y));
            dot_colors[pixel] = select(was_second, vec2(colors.x), depths == vec2(before.x));
        }
        pixel += n_workgroups.x * workgroup_size;
        if pixel >= n_pixels {
            break;
        }
    }
}
