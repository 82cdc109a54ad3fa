"""`gpu-xform info`: what model files and scans hold."""

import argparse
import json
import math
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..._core.printable import escape_line
from ...errors import ArgumentError, MeshWarning
from ...geometry.attributes import RaggedArray
from ...geometry.joints import Joint
from ...geometry.mesh import Mesh
from ...geometry.scene import Scene
from .. import files
from .. import options as groups
from ..argument_types import paths
from ..exit_codes import FAILURES, exit_code_for, format_error
from ..paths import STDIO, expand_globs, file_type, is_stream
from ..reading_options import require_no_reading_options
from ..scan_rows import describe_scan
from ..streams import print_stderr, print_stdout

USAGE = "FILE... [options]"
DESCRIPTION = """\
Print what model files hold: points, faces by their number of corners, edges,
bounds, attributes, nodes, units, comments, and what cannot be read. Of scans
(.las, .laz, .copc.laz) the header is read alone: points, format, scale, offset,
bounds, coordinate system, dimensions and records; of .zarr the layout too."""
EPILOG = """\
examples:
  gpu-xform info scan.ply
  gpu-xform info *.glb --json
  gpu-xform info tiles/*.laz
"""
MAX_TEXTS = 12
SCAN_TYPES = ("las", "laz", "zarr")


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `info`."""
    group = parser.add_argument_group("files")
    group.add_argument(
        "models",
        metavar="FILE",
        nargs="+",
        type=paths.parse_points_path,
        help="a model file, a scan, or a pattern such as *.obj; - for standard input",
    )
    groups.add_reading_options(group)
    groups.add_json(parser, "descriptions of the files")
    groups.add_general_options(parser, adapter=False)


def run(options: argparse.Namespace) -> int:
    """Print what files hold."""
    found, errors = [], []
    for path in expand_globs(options.models):
        try:
            found.append(_describe(options, path))
        except FAILURES as error:
            errors.append(error)
            print_stderr(format_error(error, "" if str(error).startswith(f"{path}: ") else path))
    if found or not errors:
        print_stdout(json.dumps(found, indent=2) + "\n" if options.json else "\n".join(map(_format, found)))
    return exit_code_for(errors[0]) if errors else 0


def _describe(options: argparse.Namespace, path: str) -> dict[str, Any]:
    """Return what a file holds, as JSON has it."""
    from ...formats import load_scene
    from ...formats.gltf import merge_scene

    kind = file_type(path, options.file_type)
    if kind != "zarr" and path != STDIO and Path(path).is_dir():
        raise ArgumentError(f"{path}: a folder; {Path(path, '*')} stands for the files in it")
    if kind in SCAN_TYPES:
        require_no_reading_options(options, path)
        return _summarize_scan(path, kind)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", MeshWarning)
        scene = files.load_model(load_scene, path, options.file_type, options.tolerance)
        is_one = len(scene) == 1 and not scene.metadata
        mesh = next(iter(scene)).models[0].model if is_one and _is_mesh(scene) else merge_scene(scene)
    sizes, counts = np.unique(np.diff(mesh.offsets), return_counts=True)
    return {
        "file": path,
        "type": kind,
        "points": mesh.n_points,
        "faces": {int(size): int(count) for size, count in zip(sizes, counts, strict=True)},
        "edges": len(mesh.edges),
        "bounds": mesh.bounds.tolist(),
        "attributes": _describe_attributes(mesh),
        "labels": {name: list(texts) for name, texts in mesh.attributes.labels.items()},
        "materials": list(mesh.attributes.material),
        "colors": _find_colors(mesh),
        "libraries": list(mesh.attributes.material.get("mtllib", ())),
        "nodes": [{"name": node.name, "parent": node.parent, "models": len(node.models)} for node in scene],
        "animations": list(scene.animations),
        "joints": [_describe_joint(joint) for joint in scene.joints.values()],
        "units": _find_units(kind, scene),
        "encoding": mesh.metadata.get(kind, {}).get("encoding"),
        "comments": _find_comments(mesh),
        "warnings": [str(warning.message) for warning in caught if issubclass(warning.category, MeshWarning)],
    }


def _summarize_scan(path: str, kind: str) -> dict[str, Any]:
    """Return what a scan holds, as JSON has it."""
    from ...chunked.summary import summarize

    if is_stream(path):
        raise ArgumentError(f"{path}: .las, .laz and .zarr are read from a file, not through a pipe")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", MeshWarning)
        found = summarize(path, kind)
    told = [str(warning.message) for warning in caught if issubclass(warning.category, MeshWarning)]
    return {"file": path, "type": kind, **found, "warnings": told}


def _describe_joint(joint: Joint) -> dict[str, Any]:
    """Return what a joint of a robot moves, in radians or metres, as JSON has it."""
    follows = None if joint.mimic is None else joint.mimic._asdict()
    limits = None if joint.lower is None else [joint.lower, joint.upper]
    return {"name": joint.name, "type": joint.kind, "node": joint.node, "limits": limits, "follows": follows}


def _format_joint(joint: dict[str, Any]) -> str:
    """Return such as "elbow (-1.57..1.57)"."""
    if joint["follows"] is not None:
        return f"{joint['name']} (follows {joint['follows']['joint']})"
    if joint["limits"] is not None:
        return f"{joint['name']} ({joint['limits'][0]:g}..{joint['limits'][1]:g})"
    return f"{joint['name']} ({joint['type']})"


def _find_colors(mesh: Mesh) -> dict[str, list[float]]:
    """Return the base colours of materials, red, green, blue and opacity from 0 to 1, by name."""
    surfaces = {
        name: content.get("pbrMetallicRoughness", {})
        for name, content in mesh.attributes.material.items()
        if isinstance(content, Mapping)
    }
    return {
        name: list(surface["baseColorFactor"]) for name, surface in surfaces.items() if "baseColorFactor" in surface
    }


def _is_mesh(scene: Scene) -> bool:
    """Return whether the one node shows one mesh where the file has it."""
    node = next(iter(scene))
    return (
        len(node.models) == 1 and isinstance(node.models[0].model, Mesh) and np.array_equal(node.transform, np.eye(4))
    )


def _describe_attributes(mesh: Mesh) -> dict[str, dict[str, str]]:
    attributes = mesh.attributes
    tables = {"point": attributes.point, "corner": attributes.corner, "face": attributes.face}
    return {what: {name: _describe_column(column) for name, column in table.items()} for what, table in tables.items()}


def _describe_column(column: Any) -> str:
    """Return the type and the number of columns, such as "3 x float32"."""
    if isinstance(column, RaggedArray):
        return f"lists of {column.dtype}"
    return " x ".join([*map(str, column.shape[1:]), str(column.dtype)])


def _find_units(kind: str, scene: Scene) -> str | None:
    """Return the unit of the coordinates, if the format says it."""
    if kind == "3mf":
        unit = scene.metadata.get("3mf", {}).get("unit", "millimeter")
        return "millimeter" if unit == "millimeter" else f"millimeter, converted from {unit}"
    if kind in ("step", "stp"):
        return scene.metadata["step"]["unit"] or "millimetre, since the file names none"
    return "metre" if kind in ("dae", "glb", "gltf", "urdf") else None


def _find_comments(mesh: Mesh) -> list[str]:
    """Return the comments that a file of any format holds."""
    held = mesh.metadata
    lines = [
        text if keyword == "comment" else f"obj_info {text}"
        for keyword, *_, text in held.get("ply", {}).get("header", ())
        if keyword in ("comment", "obj_info")
    ]
    return lines + [text.strip() for source in ("obj", "off") for text in held.get(source, {}).get("comments", ())]


def _format(found: dict[str, Any]) -> str:
    """Return a paragraph that says what a file holds."""
    if found["type"] in SCAN_TYPES:
        box = found["bounds"]
        is_box = box is not None and None not in (*box[0], *box[1])
        rows = describe_scan(found, _format_bounds(*box) if is_box else "not told" if box is None else "not finite")
        return _format_rows(found, rows)
    encoding = f", {found['encoding']}" if found["encoding"] else ""
    low, high = found["bounds"]
    faces = [f"{count:,} of {size} corners" for size, count in found["faces"].items()]
    rows = [
        ("type", f"{found['type']}{encoding}"),
        ("points", f"{found['points']:,}"),
        ("faces", f"{sum(found['faces'].values()):,}" + (f" ({_shorten(faces)})" if faces else "")),
        ("edges", f"{found['edges']:,}"),
        ("bounds", _format_bounds(low, high)),
    ]
    rows += [
        (f"per {what}", ", ".join(f"{name} ({kind})" for name, kind in table.items()))
        for what, table in found["attributes"].items()
        if table
    ]
    rows += [(name, _shorten(texts)) for name, texts in found["labels"].items()]
    colors = [f"{name} ({', '.join(f'{part:.3g}' for part in color)})" for name, color in found["colors"].items()]
    rows += [("colours", _shorten(colors))] if colors else []
    rows += [("mtllib", _shorten(found["libraries"]))] if found["libraries"] else []
    names = [node["name"] for node in found["nodes"]]
    rows += [("nodes", f"{len(names)}: {_shorten(names)}")] if len(names) > 1 else []
    joints = [_format_joint(joint) for joint in found["joints"] if joint["type"] != "fixed"]
    rows += [("joints", _shorten(joints))] if joints else []
    shown = ["animations", "comments"] if "material" in found["labels"] else ["materials", "animations", "comments"]
    rows += [(key, _shorten(found[key])) for key in shown if found[key]]
    rows += [("units", found["units"])] if found["units"] else []
    return _format_rows(found, rows)


def _format_rows(found: dict[str, Any], rows: list[tuple[str, str]]) -> str:
    """Return a file's name and its rows in columns, with what could not be read."""
    rows = [*rows, *(("warning", " ".join(text.split())) for text in found["warnings"])]
    width = max(len(name) for name, _ in rows)
    lines = [found["file"], *(f"  {name:{width}}  {text}" for name, text in rows)]
    return "".join(f"{escape_line(line)}\n" for line in lines)


def _shorten(texts: list[str]) -> str:
    """Return texts in one line, the first ones of many."""
    more = f", and {len(texts) - MAX_TEXTS} more" if len(texts) > MAX_TEXTS else ""
    return ", ".join(texts[:MAX_TEXTS]) + more


def _format_bounds(low: list[float], high: list[float]) -> str:
    """Return both corners, with six digits of the longest side of the box."""
    extent = max(b - a for a, b in zip(low, high, strict=True))
    largest = max(map(abs, (*low, *high)))
    n_digits = 6
    if 0 < extent < largest:
        n_digits += math.ceil(math.log10(largest / extent))
    return " to ".join("(" + ", ".join(f"{v:.{min(n_digits, 17)}g}" for v in point) + ")" for point in (low, high))
