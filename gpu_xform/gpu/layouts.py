"""NumPy dtypes that mirror the WGSL structs, and the only place that transposes a matrix.

WGSL stores a matrix column by column, NumPy row by row: a struct's matrix field holds the transpose.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

TRANSFORM = {
    np.dtype(np.float32): np.dtype(
        {
            "names": ["target_from_source", "nan", "n_points", "first_packet"],
            "formats": [("<f4", (4, 4)), "<f4", "<u4", "<u4"],
            "offsets": [0, 64, 68, 72],
            "itemsize": 80,
        }
    ),
    np.dtype(np.float64): np.dtype(
        {
            "names": ["target_from_source", "nan", "n_points", "first_packet"],
            "formats": [("<f8", (4, 4)), "<f8", "<u4", "<u4"],
            "offsets": [0, 128, 136, 140],
            "itemsize": 160,
        }
    ),
}

_CONVOLUTION_REALS = ["scale", "opaque", "zero", "offset_whole", "offset_fraction"]
_CONVOLUTION_SIZES = [
    "n_blocks",
    "blocks_per_row",
    "source_stride",
    "destination_stride",
    "kernel_height",
    "rows_per_sum",
]

CONVOLUTION_PASS = {
    np.dtype(real): np.dtype(
        {
            "names": [*_CONVOLUTION_REALS, *_CONVOLUTION_SIZES],
            "formats": [real] * len(_CONVOLUTION_REALS) + ["<u4"] * len(_CONVOLUTION_SIZES),
            "itemsize": n_bytes,
        }
    )
    for real, n_bytes in (("<f4", 44), ("<f8", 64))
}

SELF_TEST = np.dtype(
    {
        "names": ["entries", "scalar", "count"],
        "formats": [("<f4", (4, 4)), "<f4", "<u4"],
        "offsets": [0, 64, 68],
        "itemsize": 80,
    }
)

VERTEX_TRANSFORM = np.dtype([("n_packets", "<u4")])

TILE = np.dtype(
    [
        ("size", "<f4", (2,)),
        ("origin", "<i4", (2,)),
        ("extent", "<i4", (2,)),
        ("depth_origin", "<i4", (2,)),
        ("depth_extent", "<i4", (2,)),
        ("depth_slope_per_pixel", "<f4", (2,)),
        ("background", "<f4", (4,)),
    ]
)

DEPTH_CUE = np.dtype([("depth_scale", "<f4"), ("distance_scale", "<f4"), ("offset", "<f4"), ("amount", "<f4")])

LINE_STYLE = np.dtype(
    {
        "names": [
            *("depth_cue", "color", "line_width", "opacity"),
            *("n_edges", "instance_stride", "edge_bits", "log2_lanes"),
            *("dash_period_px", "dash_begins", "dash_ends"),
        ],
        "formats": [
            *(DEPTH_CUE, ("<f4", (4,)), "<f4", "<f4", "<u4", "<u4", "<u4", "<u4"),
            *("<f4", ("<f4", (2, 4)), ("<f4", (2, 4))),
        ],
        "offsets": [0, 16, 32, 36, 40, 44, 48, 52, 56, 64, 96],
        "itemsize": 128,
    }
)

FACES = np.dtype(
    {
        "names": [
            *("depth_cue", "n_triangles", "instance_stride", "first_id", "writes_visibility", "light_from_normals")
        ],
        "formats": [DEPTH_CUE, "<u4", "<u4", "<u4", "<u4", ("<f4", (3, 4))],
        "offsets": [0, 16, 20, 24, 28, 32],
        "itemsize": 80,
    }
)

SPLAT = np.dtype(
    {
        "names": [
            *("clip_from_points", "depth_cue", "color", "scalar_row", "radius", "opacity"),
            *("first_packet", "packet_stride", "n_points", "n_colors", "writes_colors"),
        ],
        "formats": [("<f4", (4, 4)), DEPTH_CUE, ("<f4", (4,)), ("<f4", (4,)), "<f4", "<f4", *["<u4"] * 5],
        "offsets": [0, 64, 80, 96, *range(112, 140, 4)],
        "itemsize": 144,
    }
)

PIXEL_DOTS = np.dtype([("depths", "<u4", (2,)), ("absorbance", "<u4"), ("padding", "<u4")])

EXTREMES_QUERY = np.dtype(
    {
        "names": ["n_points", "offset", "groups"],
        "formats": ["<u4", "<f4", ("<f4", (3, 3, 4))],
        "offsets": [0, 4, 16],
        "itemsize": 160,
    }
)

EXTREMES = np.dtype(
    [
        ("lowest", "<f4", (4,)),
        ("highest", "<f4", (4,)),
        ("lowest_at", "<u4", (4,)),
        ("highest_at", "<u4", (4,)),
    ]
)

CANDIDATE = np.dtype([("edge", "<u4", (2,)), ("faces", "<u4", (2,)), ("is_turned", "<u4"), ("padding", "<u4")])

SILHOUETTE_VIEW = np.dtype(
    {
        "names": ["eye", "n_candidates", "keeps_others"],
        "formats": [("<f4", (4,)), "<u4", "<u4"],
        "offsets": [0, 16, 20],
        "itemsize": 32,
    }
)

CHAIN_EDGE = np.dtype([("edge", "<u4"), ("start", "<u4"), ("end", "<u4")])

COUNT_OR_WRITE = np.dtype([("is_writing", "<u4"), ("first", "<u4")])

SPAN = np.dtype(
    {
        "names": ["ends", "edge", "is_hidden", "t_clip", "opacity", "start_px", "normalized_depth"],
        "formats": [("<f4", (4,)), "<u4", "<u4", "<f4", "<f4", "<f4", "<f4"],
        "offsets": [0, 16, 20, 24, 28, 32, 36],
        "itemsize": 48,
    }
)

SPRING_STEP = np.dtype(
    {
        "names": [
            *("gravity", "kick_s", "wind", "drift_s", "n_points", "is_first", "frame_part"),
            *("damping_s", "face_drag", "drag_rate"),
        ],
        "formats": [("<f4", (3,)), "<f4", ("<f4", (3,)), "<f4", "<u4", "<u4", "<f4", "<f4", "<f4", "<f4"],
        "offsets": [0, 12, 16, 28, 32, 36, 40, 44, 48, 52],
        "itemsize": 64,
    }
)

OBSTACLE = np.dtype(
    {
        "names": [
            *("rotation_before", "rotation_after", "center_before", "friction", "center_after", "gap"),
            *("half_size", "radius", "velocity", "is_half_space", "angular_velocity"),
        ],
        "formats": [
            *(("<f4", (4,)), ("<f4", (4,)), ("<f4", (3,)), "<f4", ("<f4", (3,)), "<f4"),
            *(("<f4", (3,)), "<f4", ("<f4", (3,)), "<u4", ("<f4", (3,))),
        ],
        "offsets": [0, 16, 32, 44, 48, 60, 64, 76, 80, 92, 96],
        "itemsize": 112,
    }
)

SLOT_PACKET = np.dtype([("rest", "<f4", (4,)), ("stiffness", "<f4", (4,)), ("shift", "<i4", (4,))])

GRID_SPRINGS = np.dtype(
    {
        "names": [
            *("along_row", "over_row", "along_column", "over_column", "shear"),
            *("height", "width", "row_shift", "column_shift", "n_blocks", "n_strips", "n_padded_rows"),
        ],
        "formats": [*[("<f4", (2,))] * 5, *["<u4"] * 7],
        "offsets": [*range(0, 40, 8), *range(40, 68, 4)],
        "itemsize": 72,
    }
)

PIN = np.dtype(
    {
        "names": ["position", "point", "velocity"],
        "formats": [("<f4", (3,)), "<u4", ("<f4", (3,))],
        "offsets": [0, 12, 16],
        "itemsize": 32,
    }
)


def to_column_major(matrix: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return a matrix (4, 4), or each of a stack (k, 4, 4), in the order in which WGSL stores it."""
    return matrix.swapaxes(-1, -2)


def pack_transforms(
    matrices: npt.NDArray[np.float64],
    dtype: np.dtype[Any],
    n_points: int,
    first_packets: npt.ArrayLike = 0,
) -> npt.NDArray[np.uint8]:
    """Return the bytes (k, itemsize) of `Transform` structs with `matrices` (k, 4, 4), rounded once to `dtype`."""
    structs = np.zeros(len(matrices), TRANSFORM[dtype])
    structs["target_from_source"] = to_column_major(matrices)
    structs["nan"] = np.nan
    structs["n_points"] = n_points
    structs["first_packet"] = first_packets
    return as_bytes(structs).reshape(len(matrices), -1)


def pack_matrices(matrices: npt.NDArray[np.float64], dtype: np.dtype[Any]) -> npt.NDArray[Any]:
    """Return `matrices` (k, 4, 4) as an `array<Mat4>`, each entry rounded once to `dtype`."""
    return np.ascontiguousarray(to_column_major(matrices), dtype)


def as_bytes(struct: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
    """Return the bytes of a struct, or of an array of structs, in memory's order."""
    return struct.reshape(-1).view(np.uint8)
