"""Fonts are found by path and by name, and no character is lost without a word."""

from pathlib import Path

import pytest

from gpu_xform.annotation import fonts
from gpu_xform.annotation.fonts import BUILT_IN, Font, choose_font, find_font
from gpu_xform.errors import ArgumentError, ArgumentTypeError


@pytest.fixture
def built_in_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The built-in font as the only one that is installed, "Plain Sans"."""
    path = tmp_path / "PlainSans-Regular.ttf"
    path.write_bytes(Font(None, 12.0).data)
    monkeypatch.setattr(fonts, "_font_folders", lambda: [tmp_path])
    fonts.list_fonts.cache_clear()
    fonts._fallback_paths.cache_clear()
    monkeypatch.setattr(fonts, "FALLBACKS", ())
    return path


@pytest.fixture(autouse=True)
def _forget_fonts() -> None:
    fonts.list_fonts.cache_clear()
    fonts._fallback_paths.cache_clear()


def test_the_font_without_a_name_is_the_one_that_pillow_brings() -> None:
    font = find_font(None, 20.0)
    assert font.family == font.name == BUILT_IN
    width, above, below = font.measure("Hxg")
    assert (above, below) == (font.ascent, font.descent)
    assert 0.6 * 20 < above < 0.9 * 20
    assert 20 < width < 40
    assert font.measure("Hxg ")[0] > width


@pytest.mark.parametrize("name", ["PlainSans-Regular", "PlainSans-Regular.ttf", "Plain Sans", "plainsans"])
def test_an_installed_font_is_found_by_its_name(name: str, built_in_file: Path) -> None:
    assert find_font(name, 9.0) == Font(str(built_in_file), 9.0)
    assert find_font(built_in_file, 9.0) == Font(str(built_in_file), 9.0)


def test_an_unknown_font_is_an_error_that_names_those_that_there_are(built_in_file: Path) -> None:
    with pytest.raises(ArgumentError, match=r"got 'PlainSan'; did you mean 'PlainSans-Regular'\?: installed are Plain"):
        find_font("PlainSan", 9.0)
    with pytest.raises(ArgumentTypeError, match=r"^font must be the path or the name of a font, got int$"):
        find_font(5, 9.0)  # type: ignore[arg-type]
    built_in_file.write_text("no font")
    with pytest.raises(ArgumentError, match=r"^font must be a TrueType or OpenType font, got"):
        find_font(built_in_file, 9.0)


def test_characters_that_no_font_has_are_an_error_that_names_them(built_in_file: Path) -> None:
    built_in = Font(None, 12.0)
    assert choose_font("plain", built_in, "labels") == built_in
    for chosen, hint in (
        (built_in, "give a font that has them"),
        (Font(str(built_in_file), 12.0), "give another font"),
    ):
        with pytest.raises(ArgumentError, match=rf"^labels must have characters .*, got '日' in 'a 日'; {hint}$"):
            choose_font("a 日", chosen, "labels")


def test_another_font_helps_the_built_in_one_out() -> None:
    wide = fonts.list_fonts().get("dejavusans")
    if wide is None:
        pytest.fail("the tests need the font DejaVu Sans")
    built_in = Font(None, 12.0)
    assert built_in.first_missing("20 µm") == "µ"
    assert choose_font("20 µm", built_in, "labels") == Font(wide, 12.0)
    assert choose_font("20 um", built_in, "labels") == built_in
