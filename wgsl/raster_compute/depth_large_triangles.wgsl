// Depths of large triangles: workgroups go through bands of the box around one, a block of pixels at a time.
#import triangle_setup

@group(0) @binding(7) var<storage, read> large: array<u32>; // workgroups (x, y, z), how many, and which

@compute @workgroup_size(workgroup_size)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
    @builtin(local_invocation_index) member: u32,
) {
    for (var i = group.x; i < large[3]; i += n_groups.x) {
        let index = large[i + 4u];
        let face = triangle(index);
        let step = vec2<i32>(block() * vec2(1u, n_groups.y));
        let start = face.low + vec2<i32>(vec2(member % block().x, group.y * block().y + member / block().x));
        for (var y = start.y; y <= face.high.y; y += step.y) {
            for (var x = start.x; x <= face.high.x; x += step.x) {
                touch_pixel(face, index, vec2(x, y));
            }
        }
    }
}
