"""One level of subdivision point by point, with dictionaries: OpenSubdiv's rules of uniform creases, word by word."""

import math
from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from gpu_xform._core.types import Float64Array

Edge = tuple[int, int]
Faces = list[list[int]]


def key(a: int, b: int) -> Edge:
    return (min(a, b), max(a, b))


def subdivide_once(
    points: Float64Array, faces: Sequence[Sequence[int]], sharpness: dict[Edge, float], corners: set[int], scheme: str
) -> tuple[Float64Array, Faces, dict[Edge, float]]:
    """Return the points, faces and sharp edges of the next level."""
    faces_of: dict[Edge, list[int]] = defaultdict(list)
    faces_at: dict[int, list[int]] = defaultdict(list)
    for f, face in enumerate(faces):
        for i, a in enumerate(face):
            faces_of[key(a, face[(i + 1) % len(face)])].append(f)
            faces_at[a].append(f)
    sharp = {e: math.inf if len(found) == 1 else sharpness.get(e, 0.0) for e, found in faces_of.items()}
    after = {e: max(s - 1, 0.0) for e, s in sharp.items()}
    edges = sorted(faces_of)
    centroids = [np.mean(points[list(face)], axis=0) for face in faces]

    def far_ends(v: int, only: dict[Edge, float] | None = None) -> list[int]:
        around = [e for e in edges if v in e and (only is None or only[e] > 0)]
        return [a if b == v else b for a, b in around]

    def vertex(v: int, rule: str, state: dict[Edge, float]) -> Float64Array:
        if rule == "corner":
            corner: Float64Array = points[v]
            return corner
        if rule == "crease":
            a, b = far_ends(v, state)
            crease: Float64Array = 0.75 * points[v] + 0.125 * (points[a] + points[b])
            return crease
        around = far_ends(v)
        n = len(around)
        far = sum(points[a] for a in around)
        if scheme == "loop":
            beta = (5 / 8 - (3 / 8 + math.cos(2 * math.pi / n) / 4) ** 2) / n
            loop: Float64Array = (1 - n * beta) * points[v] + beta * far
            return loop
        middles = sum(centroids[f] for f in faces_at[v])
        smooth: Float64Array = (n - 2) / n * points[v] + far / n**2 + middles / n**2
        return smooth

    def rule(v: int, state: dict[Edge, float]) -> str:
        count = len(far_ends(v, state))
        if v in corners or v not in faces_at or count > 2:
            return "corner"
        return "crease" if count == 2 else "smooth"

    moved = []
    for v in range(len(points)):
        now, then = rule(v, sharp), rule(v, after)
        weight = 1.0
        if now != then:
            ceasing = [s for e, s in sharp.items() if v in e and 0 < s <= 1]
            weight = min(sum(ceasing) / len(ceasing), 1.0) if ceasing else 0.0
        point = weight * vertex(v, now, sharp)
        moved.append(point if weight == 1 else point + (1 - weight) * vertex(v, then, after))
    at_edge = {}
    for e in edges:
        middle = (points[e[0]] + points[e[1]]) / 2
        weight = min(sharp[e], 1.0)
        point = weight * middle
        if weight < 1:
            one, other = faces_of[e]
            if scheme == "loop":
                wings = [next(v for v in faces[f] if v not in e) for f in (one, other)]
                smooth = 0.375 * (points[e[0]] + points[e[1]]) + 0.125 * (points[wings[0]] + points[wings[1]])
            else:
                smooth = (points[e[0]] + points[e[1]] + centroids[one] + centroids[other]) / 4
            point = point + (1 - weight) * smooth
        at_edge[e] = len(moved)
        moved.append(point)
    left = {}
    for (a, b), s in after.items():
        if s > 0:
            left[key(a, at_edge[a, b])] = left[key(b, at_edge[a, b])] = s
    children: Faces = []
    for f, face in enumerate(faces):
        rim = [at_edge[key(a, face[(i + 1) % len(face)])] for i, a in enumerate(face)]
        if scheme == "loop":
            children += [[face[i], rim[i], rim[i - 1]] for i in range(3)] + [rim]
        else:
            children += [[a, rim[i], len(moved) + f, rim[i - 1]] for i, a in enumerate(face)]
    if scheme != "loop":
        moved += centroids
    return np.array(moved), children, left
