import re

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform._core.suggestions import did_you_mean

CUBE = gx.samples.cube()


def test_the_end_of_an_error() -> None:
    assert did_you_mean("virids", ["magma", "viridis"]) == "; did you mean 'viridis'?"
    assert did_you_mean("qqq", ["magma", "viridis"]) == ""


@pytest.mark.parametrize(
    ("style", "message"),
    [
        ({"colour": "red"}, "unexpected keyword argument 'colour'; did you mean 'color'?"),
        ({"backgroud": "red"}, "unexpected keyword argument 'backgroud'; did you mean 'background'?"),
        ({"scalars": range(8), "cmap": "virids"}, "got 'virids'; did you mean 'viridis'?"),
        ({"edges": "sillhouette"}, "got 'sillhouette'; did you mean 'silhouette'?"),
        ({"hidden": "removed"}, "got 'removed'; did you mean 'remove'?"),
        ({"color": "gren"}, "got 'gren'; did you mean 'green'?"),
    ],
)
def test_misspelt_styles(style: dict[str, object], message: str) -> None:
    with pytest.raises((gx.ArgumentError, gx.ArgumentTypeError), match=re.escape(message)):
        gx.render(CUBE, **style)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"frmes": 3}, "unexpected keyword argument 'frmes'; did you mean 'frames'?"),
        ({"axi": "x"}, "unexpected keyword argument 'axi'; did you mean 'axis'?"),
        ({"backgroud": "red"}, "unexpected keyword argument 'backgroud'; did you mean 'background'?"),
        ({"progres": None}, "unexpected keyword argument 'progres'; did you mean 'progress'?"),
        ({"colour": "red"}, "unexpected keyword argument 'colour'; did you mean 'color'?"),
    ],
)
def test_misspelt_keywords_of_an_animation(keywords: dict[str, object], message: str) -> None:
    with pytest.raises(gx.ArgumentTypeError, match=re.escape(message)):
        gx.turntable("missing.obj", **keywords)  # type: ignore[arg-type]
    if "frmes" not in keywords and "axi" not in keywords:
        with pytest.raises(gx.ArgumentTypeError, match=re.escape(message)):
            gx.animate(CUBE, np.eye(4)[None], **keywords)  # type: ignore[arg-type]


def test_misspelt_precision_and_file_types(tmp_path: object) -> None:
    with pytest.raises(gx.ArgumentError, match=r"got 'flaot32'; did you mean 'float32'\?"):
        gx.transform_points([[1, 2, 3]], gx.identity(), precision="flaot32")  # type: ignore[arg-type]
    with pytest.raises(gx.MeshError, match=r"got 'objj'; did you mean 'obj'\?"):
        gx.save_mesh(CUBE, f"{tmp_path}/a.objj")
