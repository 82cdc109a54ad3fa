// Points through one matrix, a packet of four per invocation, written where it was read: half the memory to pass
// through the caches. The buffer holds whole workgroups, as those of transform_points.wgsl do.
#import real
#import transform
#import packet

@group(0) @binding(0) var<uniform> transforms: array<Transform, MATRICES_PER_DISPATCH>; // of which the first is applied
@group(0) @binding(1) var<storage, read_write> points: array<Vec4>;

override workgroup_size: u32;
override n_components: u32; // of a point, 2 or 3
override epilogue: u32;

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let i = n_components * invocation.x;
    var packet = Packet(points[i], points[i + 1u], Vec4());
    if n_components == 3u {
        packet.c = points[i + 2u];
    }
    let result = transform_packet(transforms[0], epilogue, n_components, packet);
    points[i] = result.a;
    points[i + 1u] = result.b;
    if n_components == 3u {
        points[i + 2u] = result.c;
    }
}
