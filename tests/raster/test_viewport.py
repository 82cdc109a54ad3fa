"""The viewport transform of the shaders is that of the host."""

import numpy as np

from gpu_xform.drawing.view import View, ndc_to_pixels
from gpu_xform.gpu import layouts
from gpu_xform.gpu.buffers import UNIFORM, Buffer
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.raster.tile_struct import Tile, make_tile_struct
from gpu_xform.raster.tiles import Region
from tests.support.evaluate import evaluate
from tests.support.wgsl import FOLDER

SIZE = (300, 200)
CLIP = np.array([(-1.0, 1.0, 0.3, 1.0), (2.0, -2.0, 1.0, 2.0), (0.0, 0.0, 0.0, 4.0), (-0.25, 0.375, 0.1, 0.5)])


def test_clip_space_goes_to_the_same_pixels_on_the_device_and_on_the_host(device: GpuDevice) -> None:
    tile = (FOLDER / "shared" / "tile.wgsl").read_text("utf-8")
    declarations = f"{tile}\n@group(0) @binding(0) var<uniform> given: Tile;"
    struct = make_tile_struct(Tile(Region((32, 16), (64, 48)), 5), View(SIZE, np.eye(4)))
    given = Buffer(device.context, struct.nbytes, UNIFORM, label="test")
    given.upload(layouts.as_bytes(struct))
    points = [f"vec4<f32>({', '.join(map(str, point))})" for point in CLIP.tolist()]
    expressions = [f"clip_to_pixels({point}, given.size)[{i}]" for point in points for i in (0, 1)]
    pixels = evaluate(device, declarations, expressions, given)
    assert np.reshape(pixels, (-1, 2)).tolist() == ndc_to_pixels(CLIP / CLIP[:, 3:], SIZE).tolist()
