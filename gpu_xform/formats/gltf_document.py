"""A glTF document and its buffers, as read, moved and written (`.gltf` and `.glb`).

Section numbers are those of the glTF 2.0 specification.
"""

import base64
import binascii
import copy
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, BinaryIO, TypeVar
from urllib.parse import unquote, unquote_to_bytes

import numpy as np

from .._core.git_lfs import POINTER_WORDS, is_lfs_pointer
from .._core.types import Float64Array
from ..errors import ArgumentError, ArgumentTypeError, MeshError
from ._beside import find_beside, place_beside
from ._text import quote
from .gltf_accessors import MESHOPT, get_count
from .gltf_placements import local_matrix, make_names
from .gltf_schema import explain
from .limits import budget

Result = TypeVar("Result")

_GLB_HEADER_BYTES, _CHUNK_HEADER_BYTES = 12, 8
_MIME_TYPES = {".png": "image/png", ".jpg": "image/jpeg", ".jpeg": "image/jpeg", ".webp": "image/webp"}
_MIME_TYPES |= {".ktx2": "image/ktx2", ".dds": "image/vnd-ms.dds", ".avif": "image/avif"}
# Extensions that may be required: those that say where things are or how they are packed, which are read, and those
# that change how a surface looks or describe the file, which leave points and faces as they are.
_READ = {
    *("KHR_mesh_quantization", "EXT_mesh_gpu_instancing", "KHR_node_visibility", "KHR_draco_mesh_compression", MESHOPT),
    *("KHR_xmp_json_ld", "KHR_node_selectability", "KHR_node_hoverability"),
}
# Objects and arrays within one another, as extras may hold them: what copies them calls itself as often.
_MAX_DEPTH = 100
_OF_LOOKS = ("KHR_materials_", "KHR_texture_", "KHR_lights_", "EXT_texture_", "MSFT_texture_", "EXT_lights_")


@dataclass(frozen=True, eq=False)
class Document:
    """The JSON of a glTF file, and its buffers."""

    content: Any
    buffers: list[bytes | memoryview]
    folder: Path | None = None
    """Where its images may be files."""


def read_glb(data: bytes, folder: Path | None = None) -> Document:
    """Return the document in a `.glb`; its buffers are in it, its images may be files in `folder`."""
    content, binary = _split_chunks(data)
    return replace(read_document(content, binary=binary), folder=folder)


def read_document(data: bytes, folder: Path | None = None, binary: memoryview | None = None) -> Document:
    """Return a document from its JSON.

    folder : where its buffers may lie, if they are files
    binary : the first buffer, if it is a chunk of a `.glb`
    """
    try:
        content = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise MeshError(f"the JSON is malformed: {error}") from None
    _require_shallow(content)

    def read() -> Document:
        _require_known_extensions(content)
        files = dict[str | Path, bytes]()
        buffers = [
            _read_buffer(buffer, i, folder, binary if i == 0 else None, files)
            for i, buffer in enumerate(content.get("buffers", []))
        ]
        return Document(content, buffers, folder)

    return understand(read, content)


def understand(read: Callable[[], Result], content: Any) -> Result:
    """Return what `read` makes of a document with JSON; whatever is not where it must be is a MeshError."""
    try:
        return read()
    except (AttributeError, IndexError, KeyError, TypeError):
        raise MeshError(f"the JSON is not glTF: {explain(content)}") from None


def move(document: Document, matrix: Float64Array) -> Document:
    """Return the document with each node that is in no other moved by a matrix (4, 4), the last row (0, 0, 0, 1).

    Nodes, meshes, materials, images, animations and extras stay. A node that an animation moves gets a parent with the
    matrix, because its own would end with the first keyframe.
    """

    def edit() -> Document:
        content = copy.deepcopy(document.content)
        nodes = content.get("nodes", [])
        below = {child for node in nodes for child in node.get("children", [])}
        animated = {
            channel["target"].get("node")
            for animation in content.get("animations", [])
            for channel in animation["channels"]
        }
        parents: dict[int, int] = {}
        for i in range(len(nodes)):
            if i in below:
                continue
            if i in animated:
                parents[i] = len(nodes)
                nodes.append({"matrix": matrix.T.ravel().tolist(), "children": [i]})
                continue
            try:
                with np.errstate(over="ignore", invalid="ignore"):
                    product = matrix @ local_matrix(nodes[i])
                if not np.isfinite(product).all():
                    raise MeshError("its matrix must be finite, and overflows")
            except (ArgumentError, ArgumentTypeError, MeshError) as error:
                raise MeshError(f"node {i}: {error}") from None
            for name in ("translation", "rotation", "scale"):
                nodes[i].pop(name, None)
            nodes[i]["matrix"] = product.T.ravel().tolist()
        for scene in content.get("scenes", []):
            if "nodes" in scene:
                scene["nodes"] = [parents.get(i, i) for i in scene["nodes"]]
        names = make_names([node.get("name") for node in nodes], "node")
        for i, parent in parents.items():
            nodes[parent]["name"] = f"{names[i]}, moved"
        return replace(document, content=content)

    return understand(edit, document.content)


def write_glb(document: Document, file: BinaryIO) -> None:
    """Write a document as `.glb`, with all its buffers and images in it."""

    def pack() -> tuple[bytes, bytes]:
        content = copy.deepcopy(document.content)
        binary = bytearray()
        starts = []
        buffers = _merge_buffers(content, document.buffers)
        for buffer in buffers:
            starts.append(len(binary))
            binary += buffer
            binary += b"\0" * (-len(binary) % 4)
        n_bytes = content["buffers"][0]["byteLength"] if buffers else 0
        for held in _list_slices(content):
            start = held.get("byteOffset", 0) + starts[held["buffer"]]
            held["buffer"] = 0
            if start:
                held["byteOffset"] = start
        for data, images in _read_images(content, document.folder, whole=True).items():
            start = len(binary)
            binary += data + b"\0" * (-len(data) % 4)
            _put_into_view(content, images, data, {"buffer": 0, "byteOffset": start})
        if len(buffers) == 1:
            content["buffers"][0].pop("uri", None)
            if len(binary) >= n_bytes + 4:
                content["buffers"][0]["byteLength"] = len(binary)
        elif binary:
            content["buffers"] = [{"byteLength": len(binary)}]
        return _dump(content), bytes(binary)

    text, binary = understand(pack, document.content)
    text += b" " * (-len(text) % 4)
    chunks = [_chunk(b"JSON", text)] + ([_chunk(b"BIN\0", binary)] if binary else [])
    length = _GLB_HEADER_BYTES + sum(map(len, chunks))
    if length >= 2**32:
        raise MeshError(f"a GLB holds less than 4 GiB, this one needs {length} bytes")
    file.write(b"glTF" + (2).to_bytes(4, "little") + length.to_bytes(4, "little") + b"".join(chunks))


def write_gltf(document: Document, file: BinaryIO) -> None:
    """Write a document as `.gltf`, with all its buffers and images in it."""

    def pack() -> bytes:
        content = copy.deepcopy(document.content)
        merged = _merge_buffers(content, document.buffers)
        for buffer, data in zip(content.get("buffers", []), merged, strict=True):
            if len(data) or "uri" in buffer:
                buffer["uri"] = _data_uri("application/octet-stream", data)
        for data, images in _read_images(content, document.folder, whole=False).items():
            if len(images) == 1:
                kind = images[0].get("mimeType") or guess_type(images[0]["uri"], data)
                images[0]["uri"] = _data_uri(kind, data)
            else:
                buffers = content.setdefault("buffers", [])
                buffers.append({"byteLength": len(data), "uri": _data_uri("application/octet-stream", data)})
                _put_into_view(content, images, data, {"buffer": len(buffers) - 1})
        return _dump(content)

    file.write(understand(pack, document.content))


WRITERS: dict[str, Callable[[Document, BinaryIO], None]] = {"glb": write_glb, "gltf": write_gltf}


def _list_slices(content: Any) -> Iterator[Any]:
    """Yield what names a buffer in a document."""
    for view in content.get("bufferViews", []):
        yield view
        if (packed := view.get("extensions", {}).get(MESHOPT)) is not None:
            yield packed


def _merge_buffers(content: Any, buffers: Sequence[bytes | memoryview]) -> list[bytes | memoryview]:
    """Return the buffers, of those that are the same object one, and let `content` name it: many may name one file."""
    numbers: dict[int, int] = {}
    merged: list[bytes | memoryview] = []
    described: list[Any] = []
    places = []
    for buffer, data in zip(content.get("buffers", []), buffers, strict=True):
        number = numbers.setdefault(id(data), len(merged)) if len(data) else len(merged)  # no bytes stand for others
        if number == len(merged):
            merged.append(data)
            described.append(buffer)
        kept = described[number]
        kept["byteLength"] = max(kept["byteLength"], buffer["byteLength"])
        places.append(number)
    if len(merged) < len(places):
        content["buffers"] = described
        for held in _list_slices(content):
            held["buffer"] = places[held["buffer"]]
    return merged


def _dump(content: Any) -> bytes:
    return json.dumps(content, ensure_ascii=False, separators=(",", ":")).encode("utf-8", "surrogatepass")


def _chunk(kind: bytes, data: bytes) -> bytes:
    return len(data).to_bytes(4, "little") + kind + data


def _data_uri(kind: str, data: bytes | memoryview) -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"


def _read_images(content: Any, folder: Path | None, *, whole: bool) -> dict[bytes, list[Any]]:
    """Return the bytes of images, each with those that have them: of files in `folder`, if `whole` of data URIs too."""
    files = dict[Path, bytes]()
    found: dict[bytes, list[Any]] = {}
    for image in content.get("images", []):
        data = read_image(image, folder, files)
        if data is not None and (whole or not image["uri"].startswith("data:")):
            found.setdefault(data, []).append(image)
    return found


def _put_into_view(content: Any, images: list[Any], data: bytes, place: dict[str, int]) -> None:
    """Let images be a view of a buffer, which holds their bytes at a place."""
    views = content.setdefault("bufferViews", [])
    views.append(place | {"byteLength": len(data)})
    for image in images:
        image.setdefault("mimeType", guess_type(image["uri"], data))
        del image["uri"]
        image["bufferView"] = len(views) - 1


def read_image(image: Any, folder: Path | None, files: dict[Path, bytes]) -> bytes | None:
    """Return the bytes of an image that its URI holds or names in `folder`; None for any other.

    files : what was read before
    """
    uri = image.get("uri")
    if uri is None:
        return None
    if uri.startswith("data:"):
        kind, _, text = uri.partition(",")
        try:
            return base64.b64decode(text) if kind.endswith(";base64") else unquote_to_bytes(text)
        except (binascii.Error, ValueError):
            return None
    path = find_beside(folder, folder, uri)
    if path is not None and path not in files:
        files[path] = budget().read_beside(path)
    return None if path is None else files[path]


def guess_type(uri: str, data: bytes) -> str:
    """Return the media type of an image."""
    if uri.startswith("data:"):
        return uri[5:].partition(",")[0].partition(";")[0] or "image/png"
    return _MIME_TYPES.get(Path(unquote(uri)).suffix.lower(), "image/jpeg" if data[:2] == b"\xff\xd8" else "image/png")


def _require_shallow(content: Any) -> None:
    """Raise MeshError for JSON whose objects and arrays are too deep within one another."""
    level: list[Any] = [[content]]
    for _ in range(_MAX_DEPTH + 1):
        held = (each.values() if isinstance(each, dict) else each for each in level)
        level = [value for values in held for value in values if isinstance(value, dict | list)]
        if not level:
            return
    raise MeshError(f"the JSON is more than {_MAX_DEPTH} objects and arrays deep")


def _require_known_extensions(content: Any) -> None:
    """Raise MeshError for an extension that the document says it cannot be read without (3.12), if it is unknown."""
    unknown = [
        name
        for name in content.get("extensionsRequired", [])
        if not (name in _READ or (isinstance(name, str) and name.startswith(_OF_LOOKS)))
    ]
    if unknown:
        names = ", ".join(quote(str(name)) for name in unknown)
        raise MeshError(f"it requires the extension{'s'[: len(unknown) - 1]} {names}, which cannot be read")


def _read_buffer(
    buffer: Any, i: int, folder: Path | None, binary: memoryview | None, files: dict[str | Path, bytes]
) -> bytes | memoryview:
    """Return the content of buffer i (3.6.1).

    files : what was read before, by its URI and by its path: several buffers may name one file
    """
    content: bytes | memoryview
    if "uri" in buffer:
        uri = buffer["uri"]
        if uri not in files:
            files[uri] = _fetch(uri, folder, files)
        content = files[uri]
    elif buffer.get("extensions", {}).get(MESHOPT, {}).get("fallback") is True:
        return b""  # stands for what compressed buffer views unpack to
    elif binary is not None:
        content = binary
    else:
        raise MeshError(f"buffer {i} has no content")
    declared = get_count(buffer, "byteLength")
    if declared > len(content):
        raise MeshError(f"buffer {i} declares {declared} bytes, it has {len(content)}")
    return content


def _fetch(uri: str, folder: Path | None, files: dict[str | Path, bytes]) -> bytes:
    """Return what a URI holds, or the file in `folder` that it names; no other file is opened."""
    if uri.startswith("data:"):
        kind, _, text = uri.partition(",")
        try:
            if kind.endswith(";base64"):
                return base64.b64decode(text, validate=True)
        except (binascii.Error, ValueError):
            pass
        raise MeshError(f"a data URI must be base64, got {quote(uri)}")
    if folder is None:
        raise MeshError(f"its buffer is another file, {quote(uri)}, which is not opened")
    path = find_beside(folder, folder, uri)
    if path is None:
        is_allowed = "://" not in uri and place_beside(folder, folder, uri) is not None
        more = ", which was not found" if is_allowed else ""
        raise MeshError(f"its buffer must be a file beside it, got {quote(uri)}{more}")
    if path not in files:
        files[path] = budget().read_beside(path)
    if is_lfs_pointer(files[path]):
        raise MeshError(f"its buffer {quote(uri)} is {POINTER_WORDS}")
    return files[path]


def _split_chunks(data: bytes) -> tuple[bytes, memoryview]:
    """Return the JSON chunk and the binary chunk (4.4); bytes behind the declared end are none of the file's."""
    if len(data) < _GLB_HEADER_BYTES + _CHUNK_HEADER_BYTES or data[:4] != b"glTF":
        raise MeshError(f"byte 0: expected 'glTF' and two headers, got {quote(data[:20])}")
    version, length = (int.from_bytes(data[i : i + 4], "little") for i in (4, 8))
    if version != 2:
        raise MeshError(f"byte 4: expected version 2, got {version}")
    if length > len(data):
        raise MeshError(f"byte 8: declares {length} bytes, got {len(data)}")
    chunks: dict[bytes, memoryview] = {}
    place = _GLB_HEADER_BYTES
    while place < length:
        size, kind = int.from_bytes(data[place : place + 4], "little"), data[place + 4 : place + 8]
        start = place + _CHUNK_HEADER_BYTES
        if start + size > length:
            raise MeshError(f"byte {place}: a chunk declares {size} bytes, {max(0, length - start)} are left")
        if kind == b"JSON" and place != _GLB_HEADER_BYTES:
            raise MeshError(f"byte {place}: a second JSON chunk")
        chunks.setdefault(kind, memoryview(data)[start : start + size])
        place = start + size
    if b"JSON" not in chunks:
        raise MeshError("byte 12: expected a JSON chunk")
    return bytes(chunks[b"JSON"]), chunks.get(b"BIN\0", memoryview(b""))
