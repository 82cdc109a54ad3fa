// Many points to a few: each invocation takes every n-th point to its smallest, its largest and the sum of its coordinates.
#import homogeneous

@group(0) @binding(1) var<storage, read> source: array<Real>; // packed points
@group(0) @binding(2) var<storage, read_write> partials: array<Vec4>; // lowest, highest, sum; w of each counts NaNs

override n_components: u32; // 2 or 3
override untouched: bool; // no matrix: an infinite coordinate times 0 would poison the others

// By bits: WGSL lets a compiler take it for granted that no number is NaN.
fn is_nan(x: vec3<f32>) -> vec3<bool> {
    return (bitcast<vec3<u32>>(x) & vec3(0x7fffffffu)) > vec3(0x7f800000u);
}

fn loaded(point: u32) -> Vec3 {
    let at = point * n_components;
    var p = Vec3(source[at], source[at + 1u], Real());
    if n_components == 3u {
        p.z = source[at + 2u];
    }
    if untouched {
        return p;
    }
    let m = transforms[0].target_from_source;
    return finished(m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3]);
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) grid: vec3<u32>) {
    let stride = grid.x * workgroup_size;
    if invocation.x >= transforms[0].n_points {
        return;
    }
    let first = loaded(invocation.x);
    var lowest = first;
    var highest = first;
    var sum = Vec3();
    var n_nans = vec3<u32>();
    for (var point = invocation.x; point < transforms[0].n_points; point += stride) {
        let p = loaded(point);
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
