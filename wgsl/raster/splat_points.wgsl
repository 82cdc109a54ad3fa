// Points to dots: each adds its absorbance to the pixels under it, in which the order of dots does not matter, and
// leaves its depth in those where it is among the two nearest. A second pass over the same points, by the same pipeline
// so that depths round in the same way, leaves the colours of those that are.
#import absorbance
#import coverage
#import depth_cue
#import dot
#import splat
#import tile

@group(0) @binding(0) var<uniform> tile: Tile;
@group(0) @binding(1) var<uniform> splat: Splat;
@group(0) @binding(2) var<storage, read> points: array<f32>; // packed
@group(0) @binding(3) var<storage, read> values: array<u32>; // per point: a float, or a colour, as coloring says
@group(0) @binding(4) var<storage, read> colormap: array<u32>; // straight alpha
@group(0) @binding(5) var<storage, read> face_depths: array<u32>; // bits of floats, which order as the floats do
@group(0) @binding(6) var<storage, read> block_depths: array<u32>; // from reduce_block_depths.wgsl
@group(0) @binding(7) var<storage, read> list: PointList; // from cull_points.wgsl
@group(0) @binding(8) var<storage, read_write> dots: array<atomic<u32>>; // of each pixel, as PixelDots has them
@group(0) @binding(9) var<storage, read_write> dot_colors: array<atomic<u32>>; // two per pixel; alpha is coverage too

override workgroup_size: u32;
override coloring: u32; // one of COLORING_*
override has_transparency: bool; // some of the colours may be transparent
override has_order: bool; // pixels keep their nearest dots
override hides: bool; // faces hide points
override hidden_alpha: f32; // what hidden points keep of their opacity
override is_small: bool; // a dot touches two blocks each way at most
override absorbance_steps_per_e: f32;
override min_transmittance: f32; // of a dot in a pixel

fn colormap_at(scalar: f32) -> u32 {
    return colormap[min(u32(clamp(scalar, 0.0, 1.0) * f32(splat.n_colors)), splat.n_colors - 1u)];
}

fn is_nan(bits: u32) -> bool { // by bits: WGSL lets a compiler take it for granted that no number is NaN
    return (bits & 0x7fffffffu) > 0x7f800000u;
}

fn color_of(index: u32, point: vec4<f32>) -> u32 {
    if coloring == COLORING_COORDINATE {
        return colormap_at(dot(splat.scalar_row, point));
    }
    if coloring == COLORING_SCALAR {
        let bits = values[index];
        return select(colormap_at(bitcast<f32>(bits)), 0u, is_nan(bits));
    }
    if coloring == COLORING_PACKED {
        return values[index];
    }
    return 0u;
}

fn emit(pixel: u32, alpha: f32, key: u32, color: u32) {
    let slots = 4u * pixel;
    if splat.writes_colors == 1u {
        let packed = (color & 0x00ffffffu) | (u32(alpha * 255.0 + 0.5) << 24u);
        if key == atomicLoad(&dots[slots]) {
            atomicMax(&dot_colors[2u * pixel], packed);
        }
        if key == atomicLoad(&dots[slots + 1u]) {
            atomicMax(&dot_colors[2u * pixel + 1u], packed);
        }
        return;
    }
    if has_order && key > atomicLoad(&dots[slots + 1u]) {
        let before = atomicMax(&dots[slots], key);
        atomicMax(&dots[slots + 1u], min(key, before));
    }
    if atomicLoad(&dots[slots + 2u]) < opaque_absorbance(absorbance_steps_per_e) {
        atomicAdd(&dots[slots + 2u], absorbance_of(alpha, min_transmittance, absorbance_steps_per_e));
    }
}

fn splat_point(index: u32) {
    let point = vec4(points[3u * index], points[3u * index + 1u], points[3u * index + 2u], 1.0);
    let dot = project(point);
    if splat.writes_colors == 1u && !may_be_seen(dot) {
        return;
    }
    var opacity = splat.opacity * (1.0 - splat.depth_cue.amount * normalized_depth(splat.depth_cue, dot.depth, dot.w));
    if hides && dot.depth < bitcast<f32>(face_depths[depth_index(tile, vec2<i32>(floor(dot.center)))]) {
        opacity *= hidden_alpha;
    }
    var color = 0u;
    if coloring == COLORING_UNIFORM {
        opacity *= splat.color.a;
    } else if has_transparency || splat.writes_colors == 1u {
        color = color_of(index, point);
        opacity *= f32(color >> 24u) / 255.0;
    }
    if opacity <= 0.0 {
        return;
    }
    let key = depth_bits(dot.depth);
    let axis = MajorAxis(dot.center, 0.0, 0.0, false, false);
    for (var x = dot.first.x; x <= dot.last.x; x++) {
        let spans = column_spans(axis, splat.radius, 0.0, x);
        let rows = row_range(spans);
        for (var y = max(rows.x, dot.first.y); y <= min(rows.y, dot.last.y); y++) {
            let alpha = opacity * coverage(spans, y);
            if alpha > 0.0 {
                emit(pixel_index(tile, vec2(x, y)), alpha, key, color);
            }
        }
    }
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    let first = select(list.first, 0u, splat.writes_colors == 1u);
    var i = first + invocation.x;
    if i >= list.end {
        return;
    }
    loop {
        splat_point(list.points[i]);
        i += n_workgroups.x * workgroup_size;
        if i >= list.end {
            break;
        }
    }
}
