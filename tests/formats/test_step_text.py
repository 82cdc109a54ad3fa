"""What the text of a STEP file says of itself: units by their definitions, sizes, and what is refused."""

import contextlib

import pytest

from gpu_xform.errors import MeshError
from gpu_xform.formats.limits import FileLimits, spend
from gpu_xform.formats.step_text import read_text
from tests.support import step_files
from tests.support.cost import within_cpu_s

_NUMBERS = "DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.)"


def _multiple(name: str, measure: str, *rest: str) -> tuple[str, ...]:
    return f"( CONVERSION_BASED_UNIT('{name}',{{1}}) LENGTH_UNIT() NAMED_UNIT({{3}}) )", measure, *rest


def _si(prefix: str) -> str:
    return f"( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT({prefix},.METRE.) )"


@pytest.mark.parametrize(
    ("unit", "name", "metres"),
    [
        (step_files.MILLIMETRE, "millimetre", 0.001),
        (step_files.METRE, "metre", 1.0),
        ((_si(".MICRO."),), "micrometre", 1e-6),
        ((_si(".KILO."),), "kilometre", 1000.0),
        (step_files.INCH, "inch", 0.0254),
        (
            _multiple(
                "US SURVEY FOOT", "LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(0.3048006096),{2})", _si("$"), _NUMBERS
            ),
            "us survey foot",
            0.3048006096,
        ),
    ],
    ids=["mm", "m", "um", "km", "inch", "survey foot"],
)
def test_units_have_the_size_that_the_file_defines(unit: tuple[str, ...], name: str, metres: float) -> None:
    data = step_files.write_box(3, 4, 12, unit=unit)
    found = read_text(data)
    assert (found.unit, found.metres, found.other_units) == (name, metres, ())
    assert found.size == 13.0
    assert found.data == data


@pytest.mark.parametrize(
    "unit",
    [
        _multiple(
            "FOOT",
            "LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(12.),{4})",
            _si("$"),
            _NUMBERS,
            "( CONVERSION_BASED_UNIT('INCH',{5}) LENGTH_UNIT() NAMED_UNIT({3}) )",
            "LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),{6})",
            _si(".MILLI."),
        ),
        _multiple(
            "FOOT",
            "( LENGTH_MEASURE_WITH_UNIT() MEASURE_WITH_UNIT(LENGTH_MEASURE(304.8),{2}) )",
            _si(".MILLI."),
            _NUMBERS,
        ),
    ],
    ids=["of inches", "external mapping"],
)
def test_what_the_library_would_take_for_millimetres_is_written_anew(unit: tuple[str, ...]) -> None:
    found = read_text(step_files.write_box(1, 1, 1, unit=unit))
    assert (found.unit, found.metres) == ("foot", 0.3048)
    assert b"#2 = LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(304." in found.data
    again = read_text(found.data)
    assert (again.unit, again.metres, again.data) == ("foot", 0.3048, found.data)


def test_a_file_without_a_unit_names_none() -> None:
    found = read_text(step_files.write_box(1, 1, 1).replace(b"ASSIGNED_CONTEXT((#1,", b"ASSIGNED_CONTEXT(("))
    assert (found.unit, found.metres) == (None, 0.001)


@pytest.mark.parametrize(
    ("unit", "message"),
    [
        (
            _multiple("INCH", "LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),{0})", _si("$"), _NUMBERS),
            "unit of length #1",
        ),
        (
            _multiple("INCH", "LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(-1.),{2})", _si("$"), _NUMBERS),
            "unit of length #1",
        ),
        (
            _multiple("INCH", "LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.-2),{2})", _si("$"), _NUMBERS),
            "must be a number",
        ),
        ((_si(".WIDE."),), "unit of length #1 is neither an SI unit nor a multiple of one"),
    ],
    ids=["of itself", "negative", "no number", "unknown prefix"],
)
def test_units_that_mean_nothing_are_errors(unit: tuple[str, ...], message: str) -> None:
    with pytest.raises(MeshError, match=message):
        read_text(step_files.write_box(1, 1, 1, unit=unit))


def test_comments_and_texts_do_not_count() -> None:
    data = step_files.write_box(1, 1, 1).replace(b"DATA;", b"DATA; /* #1 = ( LENGTH_UNIT() SI_UNIT($,.METRE.) ); */")
    assert read_text(data).unit == "millimetre"


def test_a_ball_has_the_size_of_its_radius() -> None:
    file = step_files.StepFile()
    file.product("ball", file.ball(7))
    assert read_text(file.text).size == 7.0


_HEAD = b"ISO-10303-21;\n"
_UNITS = (
    b"#1=(LENGTH_UNIT()"
    + b"\n" * 200_000
    + b" SI_UNIT(.MILLI.,.METRE.));#2=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(2.),#1);"
)


@pytest.mark.parametrize(
    "text",
    [
        b"/**/" * 26,
        _HEAD + b"/* " * 100_000,
        _HEAD + b"#1=( " * 100_000,
        _HEAD + b"#1=(MEASURE" * 50_000,
        _HEAD + b"#1=MEASURE_WITH_UNIT(1" + b" " * 100_000,
        _HEAD + b"GLOBAL_UNIT_ASSIGNED_CONTEXT((" * 30_000,
        _HEAD + b"".join(b"#9=NEXT_ASSEMBLY_USAGE_OCCURRENCE($,$,$,#%d,#%d);" % (i, i + 1) for i in range(10_000)),
        _HEAD
        + _UNITS
        + b"".join(b"#%d=(LENGTH_UNIT()CONVERSION_BASED_UNIT('',#2));" % i for i in range(3, 9003))
        + b"GLOBAL_UNIT_ASSIGNED_CONTEXT(("
        + b",".join(b"#%d" % i for i in range(3, 9003))
        + b"));",
    ],
    ids=["no header", "comments", "instances", "measures", "blanks", "contexts", "assemblies", "units of one"],
)
def test_no_time_grows_with_the_square_of_the_length(text: bytes) -> None:
    for _ in within_cpu_s(1):
        with contextlib.suppress(MeshError):
            read_text(text)


def test_numbers_of_more_digits_than_python_converts_are_errors() -> None:
    with pytest.raises(MeshError, match="a number of an entity is too long"):
        read_text(_HEAD + b"#1=VERTEX_POINT('',#" + b"1" * 5000 + b");")


def test_an_assembly_below_several_is_walked_once() -> None:
    usages = b"".join(
        b"#9=NEXT_ASSEMBLY_USAGE_OCCURRENCE($,$,$,#%d,#%d);" % pair for pair in [(1, 3), (2, 3), (3, 4), (3, 4), (4, 5)]
    )
    with spend(100, FileLimits(nodes=12)) as budget:  # of 1 and 2, each with one 3, two 4 and two 5
        read_text(_HEAD + usages)
    assert budget.taken() == (12, 0)
    with spend(100, FileLimits(nodes=11)), pytest.raises(MeshError, match="more than 11 nodes"):
        read_text(_HEAD + usages)


@pytest.mark.parametrize(
    "text",
    [
        b"#1=CARTESIAN_POINT('',(1.7E308,0.,0.));#2=CARTESIAN_POINT('',(-1.7E308,0.,0.));",
        b"#1=CARTESIAN_POINT('',(1.7E308,1.7E308,0.));#2=CARTESIAN_POINT('',(0.,0.,0.));",
        b"#1=CIRCLE('',#2,1.E999);",
    ],
)
def test_a_size_beyond_the_largest_numbers_is_refused(text: bytes) -> None:
    with pytest.raises(MeshError, match="its size must be finite"):
        read_text(_HEAD + text)
