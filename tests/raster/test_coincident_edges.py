"""Edges in the same place, as of faces that share no points: the last one is on top, on every driver."""

import numpy as np
import pytest

import gpu_xform as gx

RANDOM = np.random.default_rng(3)
N = 60
STARTS, ENDS = RANDOM.uniform(-1, 1, (2, N, 3))


@pytest.mark.parametrize("antialias", [True, False])
def test_the_last_of_two_edges_in_one_place_is_on_top_whichever_way_they_go(
    rasterizer_name: str, antialias: bool
) -> None:
    for start, end in zip(STARTS[:8], ENDS[:8], strict=True):
        mesh = gx.Mesh([start, end, end, start])
        picture = gx.render_array(
            mesh,
            edges=[(0, 1), (2, 3)],
            edge_colors=["red", "blue"],
            line_width=3,
            antialias=antialias,
            rasterizer=rasterizer_name,  # type: ignore[arg-type]
            size=(160, 120),
            camera={"direction": (-1, -0.5, -1)},
        )
        red, _, blue, _ = np.moveaxis(picture.astype(int), -1, 0)
        assert (blue - red).max() == 255
        assert (red - blue).max() <= 5  # pixels that lines only graze
