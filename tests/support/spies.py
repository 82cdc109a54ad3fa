"""Spies: functions of the package replaced by ones that record their calls and pass them on."""

from typing import Any

import pytest

from gpu_xform.gpu.buffers import Buffer


def record_uploads(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return a list that receives the size in bytes of every array uploaded from now on."""
    sizes: list[int] = []
    upload = Buffer.upload

    def record(buffer: Buffer, array: Any) -> None:
        sizes.append(array.nbytes)
        upload(buffer, array)

    monkeypatch.setattr(Buffer, "upload", record)
    return sizes
