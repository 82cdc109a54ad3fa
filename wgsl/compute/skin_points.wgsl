// Linear blend skinning: one point per invocation, through the matrix that its index names, or through a weighted sum
// of several.
#import real
#import transform

@group(0) @binding(0) var<uniform> transforms: array<Transform, MATRICES_PER_DISPATCH>; // how many points; no matrix
@group(0) @binding(1) var<storage, read> source: array<Real>; // packed points
@group(0) @binding(2) var<storage, read_write> destination: array<Real>;
@group(0) @binding(3) var<storage, read> indices: array<u32>; // n_influences per point
@group(0) @binding(4) var<storage, read> weights: array<Real>; // as many, or one if not is_weighted
@group(0) @binding(5) var<storage, read> matrices: array<Mat4>;

override workgroup_size: u32;
override n_components: u32; // of a point, 2 or 3
override n_influences: u32; // per point
override is_weighted: bool;
override is_inverse_transposed: bool; // for normals: of the blended matrix, not the blend of inverses
override epilogue: u32;

fn blend_matrices(point: u32) -> Mat4 {
    let first = point * n_influences;
    if !is_weighted {
        return matrices[indices[first]];
    }
    var sum = Mat4();
    for (var i = first; i < first + n_influences; i++) {
        sum += matrices[indices[i]] * weights[i];
    }
    return sum;
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let point = invocation.x;
    if point >= transforms[0].n_points {
        return;
    }
    let at = point * n_components;
    let m = blend_matrices(point);
    var p = Vec3(source[at], source[at + 1u], Real());
    if n_components == 3u {
        p.z = source[at + 2u];
    }
    var h = m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3];
    if is_inverse_transposed {
        let cofactors = array(cross(m[1].xyz, m[2].xyz), cross(m[2].xyz, m[0].xyz), cross(m[0].xyz, m[1].xyz));
        let determinant = dot(m[0].xyz, cofactors[0]);
        h = Vec4((cofactors[0] * p.x + cofactors[1] * p.y + cofactors[2] * p.z) / determinant, Real());
    }
    let result = apply_epilogue(h, epilogue, transforms[0].nan);
    destination[at] = result.x;
    destination[at + 1u] = result.y;
    if n_components == 3u {
        destination[at + 2u] = result.z;
    }
}
