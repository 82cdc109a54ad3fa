// The matrix of a stage that takes points to points, and what stands beside it.
struct Transform {
    target_from_source: Mat4,
    undefined: Real, // the host's NaN, which WGSL itself cannot write down
    n_quads: u32, // groups of four points
}

@group(0) @binding(0) var<uniform> transform: Transform;
@group(0) @binding(1) var<storage, read> source: array<Vec4>;
@group(0) @binding(2) var<storage, read_write> destination: array<Vec4>;

override workgroup_size: u32;
