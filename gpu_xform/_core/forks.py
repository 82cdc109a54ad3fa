"""Forks of a process that has opened a device: drivers hang there, so nothing may call them."""

import os

from ..errors import DeviceError

_process_of_first_device: int | None = None


def note_device() -> None:
    """Note that this process has opened a device."""
    global _process_of_first_device
    _process_of_first_device = os.getpid()


def is_fork() -> bool:
    """Return whether this process is a fork of one that has opened a device."""
    return _process_of_first_device not in (None, os.getpid())


def refuse_fork() -> None:
    """Raise `DeviceError` in a fork of a process that has opened a device."""
    if is_fork():
        raise DeviceError(
            f"process {os.getpid()} is a fork of process {_process_of_first_device}, which has opened a graphics "
            "device: drivers hang in such a child; start workers with multiprocessing.get_context('spawn')"
        )
