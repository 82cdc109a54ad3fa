"""Prefixes of errors keep the class, the attributes and the cause."""

import pytest

from gpu_xform import errors
from gpu_xform._core.error_context import has_prefix, prefix_errors


@pytest.mark.parametrize("kind", [errors.ArgumentError, errors.ArgumentTypeError, errors.SingularMatrixError])
def test_a_prefix_keeps_the_class_and_what_the_error_is_about(kind: type[errors.ArgumentError]) -> None:
    with pytest.raises(kind, match=r"^frame 3: m must be finite, got nan$") as caught, prefix_errors("frame 3"):
        raise kind.expecting("m", "be finite", "nan")
    assert type(caught.value) is kind
    assert (caught.value.argument, caught.value.expected) == ("m", "be finite")
    assert caught.value.__cause__ is None
    assert caught.value.__suppress_context__


def test_a_prefix_keeps_the_cause_and_the_notes() -> None:
    cause = KeyError("corner")

    def fail() -> None:
        error = errors.MeshError("damaged")
        error.add_note("truncated")
        raise error from cause

    with pytest.raises(errors.MeshError, match="damaged") as caught, prefix_errors("a.3mf"):
        fail()
    assert str(caught.value) == "a.3mf: damaged"
    assert caught.value.__cause__ is cause
    assert caught.value.__notes__ == ["truncated"]


def test_an_error_knows_the_prefix_that_its_message_begins_with() -> None:
    with pytest.raises(errors.MeshError) as caught, prefix_errors("frame 3"), prefix_errors("a.obj"):
        raise errors.MeshError("damaged")
    assert str(caught.value) == "frame 3: a.obj: damaged"
    assert has_prefix(caught.value, "frame 3")
    assert not has_prefix(caught.value, "a.obj")
    assert has_prefix(FileNotFoundError(2, "No such file", "a.obj"), "a.obj")
    assert not has_prefix(MemoryError(), "a.obj")


def test_other_errors_pass_unchanged() -> None:
    error = errors.DeviceError("lost")
    with pytest.raises(errors.DeviceError) as caught, prefix_errors("frame 3"):
        raise error
    assert caught.value is error
