// The points of a batch whose dots may be seen, a packet of four points per invocation: of a dense cloud most dots are
// behind others. Blocks of pixels tell how deep they are, as in Greene et al.,
// "Hierarchical Z-buffer visibility", 1993.
#import dot
#import splat
#import tile

struct GrowingList {
    end: atomic<u32>,
    first: u32,
    points: array<u32>,
}

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<uniform> splat: Splat;
@group(0) @binding(2) var<storage, read> points: array<vec4<f32>>; // packets of four points
@group(0) @binding(3) var<storage, read> block_depths: array<u32>; // from reduce_block_depths.wgsl
@group(0) @binding(4) var<storage, read_write> list: GrowingList; // as PointList

override workgroup_size: u32;
override is_small: bool; // a dot touches two blocks each way at most

fn is_listed(index: u32, point: vec3<f32>) -> bool {
    let dot = project(vec4(point, 1.0));
    if index >= splat.n_points || !dot.is_valid {
        return false;
    }
    return may_be_seen(dot);
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    let first = splat.first_packet + splat.packet_stride * invocation.x;
    let stride = splat.packet_stride * n_workgroups.x * workgroup_size;
    var packet = first;
    if 4u * packet >= splat.n_points {
        return;
    }
    loop {
        let index = 4u * packet;
        let at = 3u * packet;
        let a = points[at];
        let b = points[at + 1u];
        let c = points[at + 2u];
        let listed = vec4(
            is_listed(index, a.xyz),
            is_listed(index + 1u, vec3(a.w, b.xy)),
            is_listed(index + 2u, vec3(b.zw, c.x)),
            is_listed(index + 3u, c.yzw),
        );
        if any(listed) {
            let n_listed = vec4<u32>(listed);
            var slot = atomicAdd(&list.end, n_listed.x + n_listed.y + n_listed.z + n_listed.w);
            if listed.x { list.points[slot] = index; }
            slot += n_listed.x;
            if listed.y { list.points[slot] = index + 1u; }
            slot += n_listed.y;
            if listed.z { list.points[slot] = index + 2u; }
            slot += n_listed.z;
            if listed.w { list.points[slot] = index + 3u; }
        }
        packet += stride;
        if 4u * packet >= splat.n_points {
            break;
        }
    }
}
