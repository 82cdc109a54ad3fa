"""Tuning of a device: both rasterisers timed over numbers of edges and their lengths."""

import statistics
import time
from collections.abc import Sequence

import numpy as np

from ..drawing.camera import Camera
from ..errors import DeviceError
from ..geometry.mesh import Mesh
from ..gpu.device import GpuDevice
from ..raster.names import RasterizerName
from ..raster.tuning import MIN_RATIO_FOR_COMPUTE, TunedCell
from ..rendering.raster import render_array

EDGE_COUNTS = (1_000, 10_000, 100_000, 1_000_000)
LENGTHS_PX = (2.0, 10.0, 50.0, 200.0)
MAX_TOTAL_LENGTH_PX = 5e6  # of all edges of a picture; beyond it, CPU adapters would take minutes
SIDE_PX = 1024
LINE_WIDTH_PX = 1.5
ROUNDS = 3
MAX_DIFFERENCE = 5  # of 255, between the pictures of both: what many edges differ by, as compute shaders count them


def tune(
    device: GpuDevice, edge_counts: Sequence[int] = EDGE_COUNTS, lengths_px: Sequence[float] = LENGTHS_PX
) -> list[TunedCell]:
    """Time whole pictures of random edges by both rasterisers, alternately; raise `DeviceError` if they differ."""
    return [
        _time_cell(device, n_edges, length_px)
        for n_edges in edge_counts
        for length_px in lengths_px
        if n_edges * length_px <= MAX_TOTAL_LENGTH_PX
    ]


def format_tuning(device: GpuDevice, cells: Sequence[TunedCell]) -> str:
    """Return a table of what was measured, and which rasteriser is the faster."""
    adapter = device.adapter
    lines = [
        f"{device.name}, {adapter.driver}",
        f"{SIDE_PX} x {SIDE_PX} pixels, lines {LINE_WIDTH_PX:g} pixels wide, medians of {ROUNDS}",
        "",
        "    edges   pixels each   render, ms   compute, ms   render / compute   chosen",
    ]
    lines += [
        f"{cell.n_edges:9,}   {cell.length_px:11g}   {cell.render_ms:10.2f}   {cell.compute_ms:11.2f}   "
        f"{cell.render_ms / cell.compute_ms:16.2f}   {'compute' if cell.prefers_compute else 'render'}"
        for cell in cells
    ]
    rule = f'On this GPU, "auto" is compute where render took more than {MIN_RATIO_FOR_COMPUTE:g} times as long.'
    if adapter.kind == "CPU":
        rule = 'This device is a CPU, not a GPU: "auto" is compute here, whatever was measured.'
    return "\n".join([*lines, "", rule]) + "\n"


def _time_cell(device: GpuDevice, n_edges: int, length_px: float) -> TunedCell:
    mesh = _random_edges(n_edges, length_px)
    seconds: dict[RasterizerName, list[float]] = {"render": [], "compute": []}
    for _ in range(ROUNDS + 1):
        pictures = []
        for rasterizer, own in seconds.items():
            start = time.perf_counter()
            pictures.append(
                render_array(
                    mesh,
                    size=(SIDE_PX, SIDE_PX),
                    camera=Camera.window((0.0, SIDE_PX), (0.0, SIDE_PX)),
                    line_width=LINE_WIDTH_PX,
                    device=device,
                    rasterizer=rasterizer,
                )
            )
            own.append(time.perf_counter() - start)
        difference = int(np.abs(pictures[0].astype(np.int16) - pictures[1]).max())
        if difference > MAX_DIFFERENCE:
            raise DeviceError(f"{device!r} draws wrongly: the pictures of its rasterisers differ by {difference}/255")
    render, compute = (1e3 * statistics.median(own[1:]) for own in seconds.values())
    return TunedCell(n_edges, length_px, render, compute)


def _random_edges(n_edges: int, length_px: float) -> Mesh:
    """Return edges of one length in all directions, with their middles anywhere in the picture."""
    rng = np.random.default_rng(0)
    middles = rng.uniform(0.0, SIDE_PX, (n_edges, 2))
    angles = rng.uniform(0.0, np.pi, n_edges)
    halves = 0.5 * length_px * np.column_stack([np.cos(angles), np.sin(angles)])
    positions = np.zeros((n_edges, 2, 3))
    positions[:, 0, :2], positions[:, 1, :2] = middles - halves, middles + halves
    return Mesh(positions.reshape(-1, 3), np.arange(2 * n_edges).reshape(-1, 2))
