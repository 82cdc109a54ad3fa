"""Areas of a section: what the outlines of bodies leave solid in a plane, and how neighbours are told apart."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .._core.types import Float64Array
from .mesh import Mesh
from .sections import Ring, find_holders, signed_area

_TOUCHING = 0.01  # of the extent of all areas: boxes that are nearer belong to neighbours

Body = tuple[int, int]


class BodyRing(NamedTuple):
    """A ring, and the body that it is of: by the number of its mesh, and its own number in that."""

    ring: Ring
    body: Body


class Area(NamedTuple):
    """A solid area: its outline (k, 2) and its holes, and its body."""

    rings: Sequence[Float64Array]
    body: Body


def find_areas(given: Sequence[BodyRing]) -> list[Area]:
    """Return the solid areas of rings, which are nested in one another.

    An area is what a ring holds but for the rings in it. It is solid if more rings around it, and its own, hold a body
    than leave a hole. A ring holds a body if it turns as the outermost ring of its mesh that it lies in does.
    """
    numbers = {body: number for number, body in enumerate(dict.fromkeys(each.body for each in given))}
    rings = [each.ring._replace(body=numbers[each.body]) for each in given]
    holders = find_holders(rings)
    turns = [np.sign(signed_area(ring.points)) * (1.0 if ring.is_forward else -1.0) for ring in rings]
    signs = []
    for number, own in enumerate(holders):
        outer = [k for k in own if given[k].body[0] == given[number].body[0]]
        root = min(outer, key=lambda k: len(holders[k]), default=number)
        signs.append(turns[number] * turns[root])
    areas = []
    for number, own in enumerate(holders):
        if signs[number] + sum(signs[k] for k in own) > 0.0:
            holes = [
                rings[k].points for k, around in enumerate(holders) if number in around and len(around) == len(own) + 1
            ]
            areas.append(Area([rings[number].points, *holes], given[number].body))
    return areas


def choose_directions(areas: Sequence[Area]) -> dict[Body, int]:
    """Return 0 or 1 for each body, in turn, but another one than for the bodies beside it or around it if it can be."""
    if not areas:
        return {}
    low = np.array([area.rings[0].min(axis=0) for area in areas])
    high = np.array([area.rings[0].max(axis=0) for area in areas])
    reach = _TOUCHING * float((high.max(axis=0) - low.min(axis=0)).max())
    rows: dict[Body, list[int]] = {}
    for row, area in enumerate(areas):
        rows.setdefault(area.body, []).append(row)
    bodies = sorted(rows)
    chosen: dict[Body, int] = {}
    direction_of = np.full(len(areas), -1)
    previous = 1
    for body in bodies:
        own = rows[body]
        is_near = np.zeros(len(areas), np.bool_)
        for row in own:
            is_near |= ((low <= high[row] + reach) & (high >= low[row] - reach)).all(axis=1)
        counts = [int((direction_of[is_near] == direction).sum()) for direction in (0, 1)]
        turn = 1 - previous
        chosen[body] = previous = turn if counts[turn] <= counts[1 - turn] else 1 - turn
        direction_of[own] = previous
    return chosen


def face_areas(mesh: Mesh) -> Float64Array:
    """Return the area of each face (f,)."""
    start, end = mesh.positions[mesh.face_edges].transpose(1, 2, 0)
    a, b, c = start[[1, 2, 0]], end[[2, 0, 1]], start[[2, 0, 1]] * end[[1, 2, 0]]
    doubled = [np.bincount(mesh.face_edge_faces, row, mesh.n_faces) for row in a * b - c]
    areas: Float64Array = 0.5 * np.sqrt(np.square(doubled).sum(axis=0))
    return areas
