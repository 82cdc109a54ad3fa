// Points through one to eight matrices, a packet of four per invocation, which is loaded once. Both buffers hold whole
// workgroups, so that nothing tests whether a point exists: that would mask every load and store.
#import real
#import transform
#import packet

// Uniform, not storage: lavapipe loads a storage buffer anew for every invocation, a quarter of the whole time.
@group(0) @binding(0) var<uniform> transforms: array<Transform, MATRICES_PER_DISPATCH>;
@group(0) @binding(1) var<storage, read> source: array<Vec4>;
@group(0) @binding(2) var<storage, read_write> destination: array<Vec4>;

override workgroup_size: u32;
override n_components: u32; // of a point, 2 or 3
override n_matrices: u32; // 1 to 8
override epilogue: u32;

fn load_packet(index: u32) -> Packet {
    let i = n_components * index;
    var packet = Packet(source[i], source[i + 1u], Vec4());
    if n_components == 3u {
        packet.c = source[i + 2u];
    }
    return packet;
}

fn transform_by(matrix_index: u32, packet_index: u32, packet: Packet) {
    let result = transform_packet(transforms[matrix_index], epilogue, n_components, packet);
    let j = n_components * (transforms[matrix_index].first_packet + packet_index);
    destination[j] = result.a;
    destination[j + 1u] = result.b;
    if n_components == 3u {
        destination[j + 2u] = result.c;
    }
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let i = invocation.x;
    let packet = load_packet(i);
    // No loop: at an index that it cannot see through, lavapipe loads a matrix anew for every invocation.
    transform_by(0u, i, packet);
    if n_matrices > 1u { transform_by(1u, i, packet); }
    if n_matrices > 2u { transform_by(2u, i, packet); }
    if n_matrices > 3u { transform_by(3u, i, packet); }
    if n_matrices > 4u { transform_by(4u, i, packet); }
    if n_matrices > 5u { transform_by(5u, i, packet); }
    if n_matrices > 6u { transform_by(6u, i, packet); }
    if n_matrices > 7u { transform_by(7u, i, packet); }
}
