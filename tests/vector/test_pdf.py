"""Structure of PDF documents; what they show is in test_pictures."""

import ctypes
import dataclasses
import sys
import zlib

import numpy as np
import pypdfium2
import pytest

from gpu_xform.errors import MissingExtraError
from gpu_xform.vector import Stroke, VectorLayer, format_pdf

CROSS = VectorLayer(
    "cross",
    np.array([[10, 20, 90, 20], [50, 5, 50, 65]], np.float32),
    np.zeros(2, np.bool_),
    np.zeros(2),
    np.array([[0.0, 0.0, 0.0, 1.0]]),
    Stroke(1.5, ()),
    Stroke(1.5, ()),
)
WHITE = (1.0, 1.0, 1.0, 1.0)


def test_a_pixel_is_a_96th_of_an_inch() -> None:
    [page] = pypdfium2.PdfDocument(format_pdf((192, 97), WHITE, [CROSS]))
    assert page.get_size() == (144.0, 72.75)


def test_segments_become_lines_of_one_path() -> None:
    [page] = pypdfium2.PdfDocument(format_pdf((100, 70), WHITE, [CROSS]))
    kinds = [thing.type for thing in page.get_objects()]
    assert kinds == [pypdfium2.raw.FPDF_PAGEOBJ_PATH] * 2
    background, lines = page.get_objects()
    assert background.get_bounds() == pytest.approx((0, 0, 75, 52.5))
    assert pypdfium2.raw.FPDFPath_CountSegments(lines) == 4
    ends = []
    for i in range(4):
        x, y = ctypes.c_float(), ctypes.c_float()
        pypdfium2.raw.FPDFPathSegment_GetPoint(pypdfium2.raw.FPDFPath_GetPathSegment(lines, i), x, y)
        ends.append((x.value, y.value))
    assert ends == [(10, 20), (90, 20), (50, 5), (50, 65)]


def test_the_same_picture_is_the_same_bytes() -> None:
    assert format_pdf((100, 70), WHITE, [CROSS]) == format_pdf((100, 70), WHITE, [CROSS])


def test_each_model_is_a_layer_under_its_name() -> None:
    names = ["cross", "", "Café (1)", "日本\ud800"]
    data = format_pdf((100, 70), WHITE, [dataclasses.replace(CROSS, name=name) for name in names])
    for name in (
        b"(cross)",
        b"(model)",
        "Café (1)".encode("utf-16-be").hex().encode(),
        "日本?".encode("utf-16-be").hex().encode(),
    ):
        assert data.count(b"/Type /OCG/Name ") == 4
        assert name in data
    start = data.index(b"stream\n", data.index(b"/FlateDecode")) + len(b"stream\n")
    content = zlib.decompress(data[start : data.index(b"\nendstream", start)])
    assert [line for line in content.splitlines() if b"BDC" in line] == [b"/OC /m%d BDC" % i for i in range(4)]
    assert content.count(b"EMC") == 4


def test_nothing_is_an_empty_page() -> None:
    [page] = pypdfium2.PdfDocument(format_pdf((100, 70), (0.0, 0.0, 0.0, 0.0), []))
    assert list(page.get_objects()) == []


def test_without_its_library_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pydyf", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'gpu_xform\[pdf\]'"):
        format_pdf((100, 70), WHITE, [CROSS])
