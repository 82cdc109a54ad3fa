"""Animations of a scene's nodes: keyframes of translations, rotations, scales and morph weights."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from .._core.types import Float64Array

Interpolation: TypeAlias = Literal["STEP", "LINEAR", "CUBICSPLINE"]
Property: TypeAlias = Literal["translation", "rotation", "scale", "weights"]


class NodePoses(NamedTuple):
    """What an animation says of nodes at one time, by their names."""

    transforms: dict[str, Float64Array]
    """(4, 4) each, from the node to its parent."""
    weights: dict[str, Float64Array]
    """(t,) each, the morph weights of what the node shows."""


@dataclass(frozen=True, eq=False)
class Channel:
    """The keyframes of one property of one node.

    node : its name
    times : (k,) seconds, ascending
    values : (k, c), rotations as quaternions (x, y, z, w)
    in_tangents, out_tangents : (k, c), if the interpolation is CUBICSPLINE
    """

    node: str
    property: Property
    times: Float64Array
    values: Float64Array
    interpolation: Interpolation = "LINEAR"
    in_tangents: Float64Array | None = None
    out_tangents: Float64Array | None = None

    def at(self, time: float) -> Float64Array:
        """Return the value at a time (c,); before the first keyframe and after the last, theirs."""
        last = len(self.times) - 1
        k = min(max(int(np.searchsorted(self.times, time, side="right")) - 1, 0), last)
        if time <= self.times[k] or k == last or self.interpolation == "STEP":
            value: Float64Array = self.values[k]
        else:
            step = self.times[k + 1] - self.times[k]
            value = self._between(k, float((time - self.times[k]) / step), float(step))
        if self.property == "rotation":
            value = value / np.linalg.norm(value)
        return value

    def _between(self, k: int, t: float, step: float) -> Float64Array:
        """Return the value at a fraction t of the way from keyframe k to the next (glTF 2.0, appendix C)."""
        start, end = self.values[k], self.values[k + 1]
        if self.in_tangents is not None and self.out_tangents is not None:
            leaving, arriving = step * self.out_tangents[k], step * self.in_tangents[k + 1]
            value: Float64Array = (
                (2 * t**3 - 3 * t**2 + 1) * start
                + (t**3 - 2 * t**2 + t) * leaving
                + (3 * t**2 - 2 * t**3) * end
                + (t**3 - t**2) * arriving
            )
            return value
        if self.property == "rotation":
            return _slerp(start, end, t)
        return _mix(start, end, t)


@dataclass(frozen=True, eq=False)
class Placement:
    """Where a node is while no channel moves it: the properties that its matrix is made of."""

    translation: Float64Array
    rotation: Float64Array
    scale: Float64Array


class SceneAnimation:
    """A named animation of a scene's nodes, as a file holds it.

    channels : no two of the same property of one node
    placements : of each node that a channel moves, by its name
    """

    def __init__(self, name: str, channels: tuple[Channel, ...], placements: Mapping[str, Placement]) -> None:
        self.name = name
        self.channels = channels
        self.placements = dict(placements)

    @property
    def duration(self) -> float:
        """The time of the last keyframe, in seconds."""
        return max((float(channel.times[-1]) for channel in self.channels), default=0.0)

    def at(self, time: float) -> NodePoses:
        """Return the poses at a time in seconds, for `Scene.posed`."""
        values: dict[str, dict[str, Float64Array]] = {}
        for channel in self.channels:
            values.setdefault(channel.node, {})[channel.property] = channel.at(time)
        transforms, weights = {}, {}
        for node, moved in values.items():
            if "weights" in moved:
                weights[node] = moved["weights"]
            if moved.keys() - {"weights"}:
                rest = self.placements[node]
                transforms[node] = compose_placement(
                    moved.get("translation", rest.translation),
                    moved.get("rotation", rest.rotation),
                    moved.get("scale", rest.scale),
                )
        return NodePoses(transforms, weights)

    def __repr__(self) -> str:
        return f"<SceneAnimation {self.name!r}: {len(self.channels)} channels, {self.duration:g} s>"


def compose_placement(translation: Float64Array, rotation: Float64Array, scale: Float64Array) -> Float64Array:
    """Return the matrix T R S (4, 4); the rotation is a unit quaternion (x, y, z, w)."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotation_from_quaternion(rotation) * scale
    matrix[:3, 3] = translation
    return matrix


def rotation_from_quaternion(quaternion: Float64Array) -> Float64Array:
    """Return the rotation (..., 3, 3) of unit quaternions (..., 4) of x, y, z, w.

    It is I + 2 w K + 2 K^2, where K v = (x, y, z) x v.
    """
    x, y, z, w = np.moveaxis(quaternion, -1, 0)
    cross = np.zeros((*quaternion.shape[:-1], 3, 3))
    cross[..., 2, 1], cross[..., 0, 2], cross[..., 1, 0] = x, y, z
    cross -= np.swapaxes(cross, -1, -2).copy()
    rotation: Float64Array = np.eye(3) + 2.0 * w[..., np.newaxis, np.newaxis] * cross + 2.0 * cross @ cross
    return rotation


def _slerp(start: Float64Array, end: Float64Array, t: float) -> Float64Array:
    """Return the unit quaternion a fraction t of the shorter way from one to another (Shoemake 1985)."""
    start, end = start / np.linalg.norm(start), end / np.linalg.norm(end)
    cosine = float(start @ end)
    if cosine < 0.0:
        end, cosine = -end, -cosine
    angle = float(np.arccos(min(cosine, 1.0)))
    if angle < 1e-6:
        return _mix(start, end, t)
    turned: Float64Array = (np.sin((1.0 - t) * angle) * start + np.sin(t * angle) * end) / np.sin(angle)
    return turned


def _mix(start: Float64Array, end: Float64Array, t: float) -> Float64Array:
    mixed: Float64Array = (1.0 - t) * start + t * end
    return mixed
