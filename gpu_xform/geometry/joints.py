"""Joints: how a number moves one node of a scene in another, as in a robot."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias, get_args

import numpy as np

from .. import matrices
from .._core.arguments import as_real_array
from .._core.suggestions import did_you_mean
from .._core.types import Float64Array
from ..errors import ArgumentError

JointKind: TypeAlias = Literal["revolute", "continuous", "prismatic", "fixed", "floating", "planar"]
JOINT_KINDS: tuple[JointKind, ...] = get_args(JointKind)
MAX_NAMED = 12
MOVED_BY_A_NUMBER = ("revolute", "continuous", "prismatic")


class Mimic(NamedTuple):
    """What a joint follows: `multiplier` times the number of `joint`, plus `offset`."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True, eq=False)
class Joint:
    """A joint of a scene: a number turns its node about an axis, or moves it along one.

    name : unique among the joints of the scene; a node may have the same name
    kind : "revolute" and "continuous" turn, "prismatic" moves; the others are moved by no number
    node : the name of the node that it moves
    origin : (4, 4), the matrix from this node to its parent at 0
    axis : (3,), in the frame of the node, of length 1
    lower, upper : the limits, in radians or in the unit of the scene; None without limits
    mimic : what it follows, if it does not move by itself
    """

    name: str
    kind: JointKind
    node: str
    origin: Float64Array
    axis: Float64Array
    lower: float | None = None
    upper: float | None = None
    mimic: Mimic | None = None

    def matrix(self, value: Any) -> Float64Array:
        """Return the matrix from its node to the parent at a number, (4, 4), or at (k,) numbers, (k, 4, 4)."""
        values = np.asarray(value, np.float64)
        if self.kind == "prismatic":
            motion = np.zeros((*values.shape, 4, 4)) + np.eye(4)
            motion[..., :3, 3] = values[..., np.newaxis] * self.axis
        else:
            motion = matrices.rotate(self.axis, values)
        moved: Float64Array = self.origin @ motion
        return moved

    def __repr__(self) -> str:
        limits = "" if self.lower is None else f", {self.lower:g}..{self.upper:g}"
        follows = "" if self.mimic is None else f", follows {self.mimic.joint!r}"
        return f"<Joint {self.name!r}: {self.kind} {self.node!r}{limits}{follows}>"


def resolve_mimics(joints: Mapping[str, Joint]) -> dict[str, Mimic]:
    """Return, for every joint that follows another, which joint that moves by itself it follows in the end, and how.

    Raises ArgumentError for a joint that follows one which no number moves, or follows itself.
    """
    found: dict[str, Mimic] = {}
    for name in joints:
        chain: dict[str, Mimic] = {}  # what is not known yet, from the joint upwards
        above = name
        while above not in found and (mimic := joints[above].mimic) is not None:
            chain[above] = mimic
            if mimic.joint in chain:
                raise ArgumentError(f"joint {name!r} follows itself")
            if mimic.joint not in joints or joints[mimic.joint].kind not in MOVED_BY_A_NUMBER:
                raise ArgumentError(f"joint {above!r} follows {mimic.joint!r}, which is no joint that a number moves")
            above = mimic.joint
        last, multiplier, offset = found.get(above, Mimic(above, 1.0, 0.0))
        for follower, mimic in reversed(chain.items()):
            multiplier, offset = mimic.multiplier * multiplier, mimic.multiplier * offset + mimic.offset
            found[follower] = Mimic(last, multiplier, offset)
    return {name: found[name] for name in joints if name in found}


def place_nodes(joints: Mapping[str, Joint], values: Mapping[str, Any]) -> dict[str, Float64Array]:
    """Return the matrices, by node, of joints at numbers, and of the joints that follow them.

    values : a number, or (k,) numbers, by joint
    """
    mimics = resolve_mimics(joints)
    placed: dict[str, Float64Array] = {}
    for name, value in values.items():
        positions = _as_positions(joints[name], value, mimics)
        placed[joints[name].node] = joints[name].matrix(positions)
        for follower, mimic in mimics.items():
            if mimic.joint == name:
                joint = joints[follower]
                placed[joint.node] = joint.matrix(mimic.multiplier * positions + mimic.offset)
    return placed


def _as_positions(joint: Joint, value: Any, mimics: Mapping[str, Mimic]) -> Float64Array:
    """Return a number or numbers for a joint, checked."""
    argument = f"poses[{joint.name!r}]"
    if joint.kind not in MOVED_BY_A_NUMBER:
        way_out = f"{joint.kind} joints take none; the node {joint.node!r} takes a matrix"
        raise ArgumentError.expecting(argument, "not be a number", reason=way_out)
    if joint.name in mimics:
        reason = f"the joint follows {mimics[joint.name].joint!r}"
        raise ArgumentError.expecting(argument, "not be given", reason=reason)
    positions = as_real_array(value, argument)
    if positions.ndim > 1:
        raise ArgumentError.expecting(argument, "be a number or have shape (k,)", positions.shape)
    if joint.lower is not None and joint.upper is not None:
        outside = positions[(positions < joint.lower) | (positions > joint.upper)]
        if outside.size:
            low, high, value = joint.lower, joint.upper, outside.flat[0]
            limits, got = f"lie in {low:g}..{high:g}, the limits of the joint", f"{value:g}"
            if joint.kind != "prismatic":
                limits += f", which are {math.degrees(low):.4g}..{math.degrees(high):.4g} degrees"
                got += f", {math.degrees(value):.4g} degrees"
            raise ArgumentError.expecting(argument, limits, got)
    return positions


def name_joints(joints: Mapping[str, Joint], name: object) -> str:
    """Return the end of an error about a name that is neither a joint's nor a node's; empty without joints."""
    if not joints:
        return ""
    moved = [joint.name for joint in joints.values() if joint.kind in MOVED_BY_A_NUMBER and joint.mimic is None]
    more = f" and {len(moved) - MAX_NAMED} more" if len(moved) > MAX_NAMED else ""
    known = f"; joints that numbers move: {', '.join(map(repr, moved[:MAX_NAMED])) or 'none'}{more}"
    return did_you_mean(str(name), joints) or known


def is_number_of_joint(pose: object) -> bool:
    """Say whether a pose is a number or a row of numbers, which a joint takes, and not a matrix."""
    if hasattr(pose, "as_matrix"):
        return False
    try:
        array = np.asarray(pose)
    except (TypeError, ValueError):  # of a ragged list
        return False
    return array.ndim < 2 and array.dtype.kind in "iuf"
