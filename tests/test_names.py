"""Names that were given up: none of them is defined again.

Each row of the tables holds names of one kind, without leading underscores, and applies to one folder or file:
to the whole package if its key is "", to less if the same word is a good name for something else elsewhere.
"""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import gpu_xform

PACKAGE = Path(gpu_xform.__file__).parent
ROOT = PACKAGE.parent
WGSL = ROOT / "wgsl"

OLD_MODULES = """
    _affine _arguments _files _influences _interrupts _memmap _npy _points _precision _rebased animation/encoders/clip
    animation/encoders/folder animation/encoders/overlap animation/encoders/stills bench cameras cli/aim cli/animating
    cli/commands.py cli/failures cli/further_layers cli/layers cli/option_groups cli/pictures cli/rendering
    cli/templates cli/values cli/viewing cli/words colormaps colors comparison edge_sets formats/_joining formats/zipped
    gpu/blend_pass gpu/compute gpu/cut_pass gpu/doctor gpu/face_pass gpu/faults gpu/frame gpu/line_batches gpu/line_pass
    gpu/picture gpu/plans gpu/pool gpu/reach gpu/reduce_pass gpu/residents gpu/shapes gpu/silhouette_pass gpu/targets
    gpu/tiles gpu/transform_pass images mesh pictures point_buffer polygons progress scene streaming transform
    triangulation vector/_chains vector/_paths vector/_text vector/painters/boxes vector/painters/groups
    vector/painters/knots vector/painters/order vector/painters/pieces vector/painters/precedence vector/strokes
    viewer/keys viewer/looks viewer/panel
"""

OLD_TEST_MODULES = """
    begun inked oracles screen terminals test_batches test_begun test_inputs test_nearness test_views test_visibility
    visibility
"""

OLD_PYTHON: dict[str, dict[str, str]] = {
    "class": {
        "": """
            Ball Clip Drawn FacePass Finish Given LinePass Look Painted Pairs Plan Pool Residents Shape Shaped Shaper
            Strokes Subject Target
        """,
        "compute": "Points",
        "drawing": "Points Stage",
        "gpu": "Points",
        "raster": "Points",
    },
    "function": {
        "": """
            about angle apply apply_in_place around backdrop batches begun by_face called chained chosen circles
            clipped computed described direction embedded encoded extremes fans finite following further hides
            hundredths image in_bindings in_picture is_cycle is_one_array is_plain kind knotted let_go levels listed
            looking lost_by_distance mapped mapped_once matching max_rows may_show meant members mind_interrupts
            n_keys naming nanoseconds_a_tick needs_distance next_ground number octets of_circles of_crossing
            one_by_one opened other_fill outermost outline over_edges packed padded painted picked pixel_depth pixels
            planned posed products reach_through reached related require_one_aim rounded_up saver say scaling shaped
            staged staged_once strays strength_constants strips taken together turn_up uninterrupted unpacked unscaled
            untangled unusual whole_number with_depth without_silhouette words
        """,
        "raster": "cut",
    },
    "method": {
        "": """
            arrive arrived begin_ink downloaded draw_ink end_ink forget give_back give_up go_along go_through is_clear
            lay leave meant outline paint recording resident seen strays suits
        """,
        "gpu": "padded pixels take",
        "gpu/buffer_pool.py": "get",
        "raster": "pixels take",
        "vector/painters": "chosen cross",
    },
    "constant": {
        "": """
            ALIKE AT_ONCE Codes Cue FACE_CYCLE FAR FARTHEST FEW GO_BACK GRID Height INK_STEPS NARROW NEAR NEARLY
            NOTHING Octets POINTS_A_PIXEL RIM ROOM SIXTEEN SLIVER TURN_A_HEIGHT UNIT_CORNERS ZOOM_A_NOTCH
        """,
        "compute": "ROWS_AT_ONCE",
        "vector/painters": "FIRST LEVEL SECOND",
    },
    "field": {
        "": """
            AN_EDGE AS_IT_IS A_POINT DIVIDED_BY_W NORMALIZED ONE are_dots are_outlines color_places cue first_mark
            ground holds hull is_clear marks numbered one_for_each picks pixel_depth shaped shares stays strength
            turned
        """,
        "compute": "n_rows",
        "drawing": "by_face n_rows role",
        "gpu": "number role",
        "vector/painters": "sides",
    },
    "parameter": {
        "": """
            again backdrop color_places cue first_mark further ground knife knives marks numbered picks shares stays
            strength way_back ways_back
        """,
        "animation": "after",
        "compute": "n_rows",
        "drawing": "role",
        "gpu": "role",
        "raster": "after role",
        "rendering": "after",
    },
}

OLD_WGSL_FILES = """
    across asked blend_colored_lines blend_faces blend_ink blend_points blend_points_f32 blend_points_f64
    blend_thin_lines copy_points_f32 copy_points_f64 cue cut_lines each_covered each_inked each_mark edge far_along
    fill_picture find_silhouette homogeneous ink ink_colored_lines ink_lines lay_faces lay_ink lay_large_faces mark
    mark_thin_lines nearness over project_vertices project_vertices_f32 project_vertices_f64 quad quad_2d
    reduce_points_f32 reduce_points_f64 scan strength transform_in_place_2d_f32 transform_in_place_2d_f64
    transform_in_place_f32 transform_in_place_f64 transform_points_2d_f32 transform_points_2d_f64 transform_points_f32
    transform_points_f64 triangle
"""

OLD_WGSL: dict[str, dict[str, str]] = {
    "name": {
        "": """
            AS_IT_IS BAND BESIDE BIAS COLOR_AN_EDGE COLOR_A_POINT DIVIDED_BY_W LARGE NEARLY NORMALIZED ONE_COLOR
            OPAQUE OVERFULL_INK PALE RIM Strips Turn Walk along anchor counts each_mark exists far_along farness
            farness_at finish finished first_quad foot ground_at high ink ink_of ink_steps inked inside is_asked
            is_clear is_elsewhere is_marking large lay lay_ink least_light leave left_of low mark_of n_keys n_rows
            nearest nearness numbered opaque_ink part_at pieces place_of put quad quad_2d rim rim_lean rise rows_of
            run strength strength_at strength_in_sight strips_at take touch_pixel undefined unsure untouched
        """,
    },
    "member": {
        "Faces": "n_points",
        "Style": "n_points",
    },
}

PARTICIPLE = re.compile(r"[a-z]+ed")  # free functions are verbs; `transformed` is a method of what is not changed
SUPERLATIVE = re.compile(r"(MOST|LEAST|LARGEST|WIDEST|LONGEST)_")  # MAX_ and MIN_ say the same


@cache
def python_definitions(file: Path) -> tuple[tuple[str, str], ...]:
    """Return the kind and the name of every class, function, method, constant, field and parameter."""
    return tuple(_find_definitions(file))


def _find_definitions(file: Path) -> Iterator[tuple[str, str]]:
    waiting: list[tuple[ast.AST, str]] = [(ast.parse(file.read_text("utf-8")), "module")]
    while waiting:
        node, scope = waiting.pop()
        inner = scope
        match node:
            case ast.ClassDef():
                yield "class", node.name
                inner = "class"
            case ast.FunctionDef() | ast.AsyncFunctionDef():
                yield ("method" if scope == "class" else "function"), node.name
                inner = "function"
            case ast.arg():
                yield "parameter", node.arg
            case ast.Name(ctx=ast.Store()) if scope in {"module", "class"}:
                yield {"module": "constant", "class": "field"}[scope], node.id
            case ast.Attribute(value=ast.Name(id="self"), ctx=ast.Store()):
                yield "field", node.attr
        waiting.extend((child, inner) for child in ast.iter_child_nodes(node))


def wgsl_definitions(file: Path) -> Iterator[tuple[str, str]]:
    """Yield ("name", name) of every function, type, constant, override and variable, and (struct, member)."""
    source = re.sub(r"//[^\n]*", "", file.read_text("utf-8"))
    for struct, body in re.findall(r"\bstruct\s+(\w+)\s*\{([^}]*)\}", source):
        yield from ((struct, member) for member in re.findall(r"(\w+)\s*:", body))
        yield from (("name", member) for member in re.findall(r"(\w+)\s*:", body))
    for name in re.findall(r"\b(?:fn|struct|alias|const|override|let|var(?:\s*<[^>]*>)?)\s+(\w+)", source):
        yield "name", name
    for parameters in re.findall(r"\bfn\s+\w+\s*\(([^{]*)\)", source):
        yield from (("name", name) for name in re.findall(r"(\w+)\s*:", parameters))


PYTHON_FILES = sorted(PACKAGE.rglob("*.py"))
WGSL_FILES = sorted(WGSL.rglob("*.wgsl"))


def test_an_old_module_is_gone() -> None:
    for module in OLD_MODULES.split():
        path = PACKAGE / module
        assert not path.with_suffix(".py").exists(), module
        assert path.suffix or not path.exists(), module


def test_an_old_module_of_the_tests_is_gone() -> None:
    assert not {file.stem for file in (ROOT / "tests").rglob("*.py")} & set(OLD_TEST_MODULES.split())


def test_an_old_shader_file_is_gone() -> None:
    assert not {file.stem for file in WGSL_FILES} & set(OLD_WGSL_FILES.split())


def test_no_old_name_is_defined_in_python() -> None:
    for file in PYTHON_FILES:
        place = file.relative_to(PACKAGE).as_posix()
        old = {
            (kind, name)
            for kind, rows in OLD_PYTHON.items()
            for where, names in rows.items()
            if where in {"", place} or place.startswith(f"{where}/")
            for name in names.split()
        }
        defined = {(kind, name.lstrip("_")) for kind, name in python_definitions(file)}
        assert not sorted(defined & old), file
        assert not sorted(name for _, name in defined if SUPERLATIVE.match(name)), file


def test_no_free_function_is_a_past_participle() -> None:
    for file in PYTHON_FILES:
        functions = {name.lstrip("_") for kind, name in python_definitions(file) if kind == "function"}
        assert not sorted(
            name for name in functions if PARTICIPLE.fullmatch(name) and name not in {"embed", "feed", "seed"}
        ), file


def test_no_old_name_is_defined_in_a_shader() -> None:
    old = {("name", name) for names in OLD_WGSL["name"].values() for name in names.split()}
    old |= {(struct, name) for struct, names in OLD_WGSL["member"].items() for name in names.split()}
    for file in WGSL_FILES:
        defined = set(wgsl_definitions(file))
        assert not sorted(defined & old), file
        assert not sorted(name for _, name in defined if SUPERLATIVE.match(name)), file


def test_definitions_of_every_kind_are_found(tmp_path: Path) -> None:
    python = tmp_path / "module.py"
    python.write_text("""
from os import path as kind
Alias = dict[str, int]
first, (SECOND, *rest) = 1, (2, 3)
class Shape(Base):
    hull: int = 3
    stays, shares = 1, 2
    def lay(self, picks, /, *args, again=1, **rest):
        self.cue = local = lambda strength: strength
        self.other.attribute, local.attribute = 1, 2
    async def arrive(self): ...
if True:
    LATE: int = 4
def begun(after):
    inside = 1
    def nested(deep): ...
for index in range(3): ...
""")
    assert set(python_definitions(python)) == {
        *(("constant", name) for name in ("Alias", "first", "SECOND", "rest", "LATE", "index")),
        *(("class", "Shape"), ("field", "hull"), ("field", "stays"), ("field", "shares"), ("field", "cue")),
        *(("method", "lay"), ("method", "arrive"), ("function", "begun"), ("function", "nested")),
        *(("parameter", name) for name in ("self", "picks", "args", "again", "rest", "strength", "after", "deep")),
    }
    shader = tmp_path / "shader.wgsl"
    shader.write_text("""
// fn commented(out: f32)
alias Real = f32;
struct Style { @align(16) color: vec4<f32>, // rim: f32
    n_points: u32, }
const LARGE: f32 = 1.0;
override numbered: bool = false;
@group(0) @binding(1) var<storage, read_write> ink: array<u32>;
fn lay(part: vec2<f32>, @builtin(position) at: vec4<f32>) -> f32 { let foot = 1.0; var low: f32 = foot; return low; }
""")
    names = ("Real", "Style", "color", "n_points", "LARGE", "numbered", "ink", "lay", "part", "at", "foot", "low")
    assert set(wgsl_definitions(shader)) == {
        *(("Style", "color"), ("Style", "n_points")),
        *(("name", name) for name in names),
    }
