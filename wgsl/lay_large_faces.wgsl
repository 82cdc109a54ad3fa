// Depths of large triangles: a workgroup takes some of their rows together, a pixel an invocation.
#import triangle

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
        for (var y = face.low.y + i32(group.y); y <= face.high.y; y += i32(n_groups.y)) {
            for (var x = face.low.x + i32(member); x <= face.high.x; x += i32(workgroup_size)) {
                touch_pixel(face, index, vec2(x, y));
            }
        }
    }
}
