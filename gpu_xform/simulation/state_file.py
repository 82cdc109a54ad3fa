"""State files: all that a simulation goes on from, as bytes, and those bytes read back."""

import io
import zipfile
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..errors import ArgumentError, ArgumentTypeError, SimulationError
from ..gpu.layouts import SPRING_STEP
from .spring_system import SpringSystem

STATE_VERSION = 1


@dataclass(frozen=True, eq=False)
class SavedState:
    """A state, but for what acts on the points.

    positions, velocities : (n, 4) float32, as a stepper reads them
    epoch_s, n_frames, frame_s : the time is that of the epoch, and so many frames later
    lag_s : how far the velocities are behind the positions
    step : `layouts.SPRING_STEP`, of the last frame
    """

    positions: npt.NDArray[np.float32]
    velocities: npt.NDArray[np.float32]
    epoch_s: float
    n_frames: int
    frame_s: float
    lag_s: float
    step: npt.NDArray[np.void]


def pack_state(state: SavedState, system: SpringSystem) -> bytes:
    """Return a state of a system as bytes; raise SimulationError if a number is not finite."""
    positions, velocities = state.positions.copy(), state.velocities
    wrong = ~(np.isfinite(positions[:, :3]) & np.isfinite(velocities[:, :3])).all(axis=1)
    if wrong.any():
        time_s = state.epoch_s + state.n_frames * state.frame_s
        message = f"point {int(np.argmax(wrong))} has no finite position and velocity, at {time_s:g} s"
        raise SimulationError(f"{message}: restore an earlier state, or reset()", frame=state.n_frames)
    positions[:, 3] = system.inverse_masses  # who restores it holds no point
    arrays = {
        "version": np.array(STATE_VERSION),
        "system": np.array(system.fingerprint()),
        "parts": np.array(list(system.describe_parts().items())),
        "positions": positions,
        "velocities": velocities,
        "clock": np.array([state.epoch_s, state.n_frames, state.frame_s, state.lag_s]),
        "step": state.step,
    }
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:  # np.savez would write the time of day as well
        for name, array in arrays.items():
            content = io.BytesIO()
            np.lib.format.write_array(content, array, allow_pickle=False)
            archive.writestr(zipfile.ZipInfo(f"{name}.npy"), content.getvalue())
    return file.getvalue()


def unpack_state(given: bytes | bytearray | memoryview, system: SpringSystem) -> SavedState:
    """Return what `pack_state` made bytes of; raise ArgumentError for those of another system, or of something else."""
    if not isinstance(given, bytes | bytearray | memoryview):
        raise ArgumentTypeError.expecting("state", "be the bytes that state() returns", type(given).__name__)
    content = bytes(given)
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        version, fingerprint = int(arrays["version"]), str(arrays["system"])
        parts = dict(arrays.get("parts", np.empty((0, 2), np.str_)).tolist())
        epoch_s, n_frames, frame_s, lag_s = arrays["clock"].tolist()
        step = np.zeros((), SPRING_STEP)  # whose padding is zeros, unlike that of a copy
        for member in SPRING_STEP.names or ():
            step[member] = arrays["step"][member]
        state = SavedState(arrays["positions"], arrays["velocities"], epoch_s, int(n_frames), frame_s, lag_s, step)
    except Exception:  # zipfile and NumPy raise what their many parts raise
        got = f"{len(content):,} bytes that are something else, or damaged"
        raise ArgumentError.expecting("state", "be what Springs.state() returned", got) from None
    if version != STATE_VERSION:
        raise ArgumentError.expecting("state", f"have version {STATE_VERSION}", version)
    if fingerprint != system.fingerprint():
        raise ArgumentError.expecting(
            "state", "be that of a system with the same points and springs", _describe_difference(system, parts)
        )
    return state


def _describe_difference(system: SpringSystem, others: dict[str, str]) -> str:
    """Return what differs between two systems, by the texts of their parts: how many there are, if not as many."""
    own = system.describe_parts()
    counts = [
        f"{others[name].split()[0]} {name}, not {own[name].split()[0]}"
        for name in ("points", "springs", "faces")
        if name in others and others[name].split()[0] != own[name].split()[0]
    ]
    if counts:
        return f"one of {'; '.join(counts)}"
    names = [name for name in own if name in others and others[name] != own[name]]
    return f"one with other {', '.join(names)}" if names else "another"
