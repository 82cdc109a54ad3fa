// Many points to a few: each invocation reduces every n-th point to its smallest, its largest and the sum of its
// coordinates.
#import real
#import transform

@group(0) @binding(0) var<uniform> transforms: array<Transform, MATRICES_PER_DISPATCH>; // of which the first is applied
@group(0) @binding(1) var<storage, read> source: array<Real>; // packed points
@group(0) @binding(2) var<storage, read_write> partials: array<Vec4>; // lowest, highest, sum; w of each counts NaNs

override workgroup_size: u32;
override n_components: u32; // of a point, 2 or 3
override is_identity: bool; // no matrix: an infinite coordinate times 0 would poison the others
override epilogue: u32;

// By bits: WGSL lets a compiler take it for granted that no number is NaN.
fn is_nan(x: vec3<f32>) -> vec3<bool> {
    return (bitcast<vec3<u32>>(x) & vec3(0x7fffffffu)) > vec3(0x7f800000u);
}

fn load_point(point: u32) -> Vec3 {
    let at = point * n_components;
    var p = Vec3(source[at], source[at + 1u], Real());
    if n_components == 3u {
        p.z = source[at + 2u];
    }
    if is_identity {
        return p;
    }
    let m = transforms[0].target_from_source;
    return apply_epilogue(m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], epilogue, transforms[0].nan);
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    let stride = n_workgroups.x * workgroup_size;
    if invocation.x >= transforms[0].n_points {
        return;
    }
    let first = load_point(invocation.x);
    var lowest = first;
    var highest = first;
    var sum = Vec3();
    var n_nans = vec3<u32>();
    for (var point = invocation.x; point < transforms[0].n_points; point += stride) {
        let p = load_point(point);
        n_nans += vec3<u32>(is_nan(vec3<f32>(p)));
        lowest = min(lowest, p);
        highest = max(highest, p);
        sum += p;
    }
    let at = 3u * invocation.x;
    partials[at] = Vec4(lowest, Real(n_nans.x));
    partials[at + 1u] = Vec4(highest, Real(n_nans.y));
    partials[at + 2u] = Vec4(sum, Real(n_nans.z));
}
