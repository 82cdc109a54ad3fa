// Silhouettes: edges between a face that looks at the eye and one that looks away; the others become edges of no point.
// A face that is seen edge-on looks away, or rounding would choose between both of its sides, edge by edge.
struct Candidate {
    edge: vec2<u32>,
    faces: vec2<u32>, // the second NO_FACE if the edge is drawn in every view
    is_turned: u32, // the two faces are wound against each other
    padding: u32,
}

struct SilhouetteView {
    eye: vec4<f32>, // in the points' frame, homogeneous
    n_candidates: u32,
    keeps_others: u32, // in place of silhouettes
}

const NO_FACE = 0xffffffffu;
const NO_POINT = 0xffffffffu;
const EDGE_ON_SINE = 1e-4; // of the angle to the view: a face that is no wider than a tenth of a pixel

@group(0) @binding(0) var<uniform> view: SilhouetteView;
@group(0) @binding(1) var<storage, read> candidates: array<Candidate>;
@group(0) @binding(2) var<storage, read> planes: array<vec4<f32>>; // of the faces
@group(0) @binding(3) var<storage, read_write> edges: array<vec2<u32>>;

override workgroup_size: u32;

fn looks_at_eye(face: u32, sign: f32) -> bool {
    return sign * dot(planes[face], view.eye) > EDGE_ON_SINE * length(view.eye.xyz);
}

fn extract(index: u32) {
    let candidate = candidates[index];
    var is_drawn = candidate.faces.y == NO_FACE;
    if !is_drawn {
        let sign = select(1.0, -1.0, candidate.is_turned == 1u);
        is_drawn = looks_at_eye(candidate.faces.x, 1.0) != looks_at_eye(candidate.faces.y, sign);
    }
    edges[index] = select(vec2(NO_POINT), candidate.edge, is_drawn != (view.keeps_others == 1u));
}

@compute @workgroup_size(workgroup_size)
fn main(@builtin(global_invocation_id) invocation: vec3<u32>, @builtin(num_workgroups) n_workgroups: vec3<u32>) {
    var index = invocation.x;
    if index >= view.n_candidates {
        return;
    }
    loop {
        extract(index);
        index += n_workgroups.x * workgroup_size;
        if index >= view.n_candidates {
            break;
        }
    }
}
