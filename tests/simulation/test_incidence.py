"""Springs in slots: each kind of slots holds every spring once at either end, and moves the points alike."""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import gpu_xform as gx
from gpu_xform.simulation import incidence
from gpu_xform.simulation.incidence import MAX_PACKETS, Slots, SpringSlots, pack_fans, pack_slots
from gpu_xform.simulation.spring_system import SpringSystem
from tests.support.spring_models import make_chain, make_cloth, make_reference


def system_of(springs: gx.Springs) -> SpringSystem:
    return springs._system


def state_of(springs: gx.Springs) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return the positions (n, 3), and the velocities half a step earlier."""
    positions, velocities = springs._stepper.read_state()
    return positions[:, :3].astype(np.float64), velocities[:, :3].astype(np.float64)


def ragged_cloth() -> gx.Springs:
    """Return a mesh whose points are in no order, with springs that are all different."""
    rng = np.random.default_rng(3)
    sphere = gx.samples.icosphere(2)
    order = rng.permutation(sphere.n_points)
    mesh = gx.Mesh(sphere.positions[np.argsort(order)] * (1.0, 1.3, 0.7), order[np.asarray(sphere.faces)])
    return gx.Springs(mesh, mass=0.1, stretch=300.0, bend=20.0, damping=1e-4, pinned=[5])


def two_kinds() -> gx.Springs:
    """Return springs of two rest lengths, whose ends are any number of points apart."""
    rng = np.random.default_rng(4)
    pairs = np.concatenate([rng.permutation(60).reshape(-1, 2), rng.permutation(60).reshape(-1, 2)])
    rest = np.repeat([1.0, 0.5], 30)
    return gx.Springs(rng.random((60, 3)), springs=pairs, stiffness=20.0, rest=rest, mass=1.0, damping=1e-3)


MODELS: dict[Slots, Callable[[], gx.Springs]] = {
    Slots.LISTED: ragged_cloth,
    Slots.ALIKE: two_kinds,
    Slots.SHIFTED: lambda: make_cloth(7, 10, damping=1e-4, pinned=[0, 9]),
}


def list_slots(packed: SpringSlots, n_points: int) -> set[tuple[int, int, float, float]]:
    """Return (point, other end, rest length, stiffness) of every slot that is used."""
    found = set()
    for packet in range(packed.n_packets):
        for point in range(n_points):
            for slot in range(4):
                if packed.kind is Slots.LISTED:
                    end, rest, stiffness = packed.springs[packet, point, :, slot]
                    values = rest.view(np.float32), stiffness.view(np.float32)
                else:
                    values = packed.packets[packet]["rest"][slot], packed.packets[packet]["stiffness"][slot]
                    end = packed.springs[packet, point, slot] if packed.kind is Slots.ALIKE else point
                    if packed.kind is Slots.SHIFTED and packed.masks[point] >> (4 * packet + slot) & 1:
                        end = point + packed.packets[packet]["shift"][slot]
                if end != point:
                    row = (point, int(end), float(values[0]), float(values[1]))
                    assert row not in found
                    found.add(row)
    return found


@pytest.mark.parametrize("kind", Slots)
def test_every_spring_has_a_slot_at_either_end(kind: Slots) -> None:
    system = system_of(MODELS[kind]())
    packed = pack_slots(system)
    assert packed.kind is kind
    found = {(point, end): (rest, stiffness) for point, end, rest, stiffness in list_slots(packed, system.n_points)}
    assert len(found) == 2 * len(system.pairs)
    for (a, b), rest, stiffness in zip(system.pairs.tolist(), system.rest, system.stiffness, strict=True):
        for ends in ((a, b), (b, a)):
            np.testing.assert_allclose(found[ends], (rest, stiffness), rtol=2.0**-22)


@pytest.mark.parametrize("kind", Slots)
@pytest.mark.parametrize("model", Slots)
def test_every_kind_moves_the_points_alike(kind: Slots, model: Slots, monkeypatch: pytest.MonkeyPatch) -> None:
    """A kind that the model has no use for falls back to lists.

    Single steps are within derived bounds of float64. Over 200 of them, springs that begin compressed multiply what is
    rounded: the reference stores float32 as well, so that what is left to differ is how accelerations are rounded, by
    at most 8.4e-7 m on four drivers and on the host.
    """
    for name in ("LISTED", "ALIKE", "SHIFTED"):
        monkeypatch.setattr(incidence, f"{name}_COST", 0.0 if name == kind.name else 1e3)
    springs, other = MODELS[model](), MODELS[model]()
    dt = min(1e-3, 0.5 * springs.largest_step)
    whole = make_reference(springs, damping=springs.damping, stored=np.float32)
    whole.run(200, dt)
    single = make_reference(springs, damping=springs.damping)
    late = single.kick(single.velocities, -dt / 2.0)
    for part in range(20):
        bounds = single.bound_rounding(late, dt)
        late = single.step(late, dt)
        springs.step(1, dt)
        factor = 3.0 if part == 0 else 1.0  # velocities were kicked back by half a step, with as much rounding
        for found, expected, bound in zip(state_of(springs), (single.positions, late), bounds, strict=True):
            assert (np.abs(found - expected) <= factor * bound).all()
        springs.step(9, dt)
        single.positions, late = state_of(springs)
    np.testing.assert_allclose(springs.positions, whole.positions, rtol=0.0, atol=2e-6)
    assert np.abs(springs.positions - springs._system.points).max() > 1e-4
    other.step(200, dt)
    assert all(map(np.array_equal, state_of(other), state_of(springs)))


@pytest.mark.parametrize(
    ("springs", "n_packets"),
    [(make_cloth(30, 40), 3), (make_chain(20, length=0.1, stiffness=3.0, mass=0.1), 1)],
    ids=["cloth", "chain"],
)
def test_regular_models_need_no_lists(springs: gx.Springs, n_packets: int) -> None:
    packed = pack_slots(system_of(springs))
    assert (packed.kind, packed.n_packets, packed.springs.nbytes) == (Slots.SHIFTED, n_packets, 0)


def test_rest_lengths_are_one_only_if_float32_can_hardly_tell_them_apart() -> None:
    points = np.cumsum([[0.0, 0.0, 0.0], *(3 * [[1.0, 0.0, 0.0]])], axis=0)
    links = [[0, 1], [1, 2], [2, 3]]
    for spread, n_slots in ((1e-7, 2), (1e-5, 4)):
        springs = gx.Springs(points, springs=links, stiffness=1.0, rest=[1.0, 1.0 + spread, 1.0], mass=1.0)
        assert len(list_slots(pack_slots(system_of(springs)), 4)) == 6
        used = pack_slots(system_of(springs)).packets["stiffness"]
        assert np.count_nonzero(used) == n_slots


def test_more_slots_than_a_mask_has_bits_are_listed() -> None:
    n = 4 * MAX_PACKETS + 2
    star = [[0, k] for k in range(1, n)]
    springs = gx.Springs(np.random.default_rng(1).random((n, 3)), springs=star, stiffness=1.0, mass=1.0)
    assert pack_slots(system_of(springs)).kind is Slots.LISTED


def test_fans_hold_every_corner_of_every_triangle() -> None:
    triangles = np.array([[0, 1, 2], [2, 1, 3], [4, 0, 2]])
    fans = pack_fans(triangles, 6)
    assert fans.shape == (3, 6, 2)
    found = {(i, *fan) for fan_row in fans.tolist() for i, fan in enumerate(fan_row) if fan != [i, i]}
    assert found == {tuple(np.roll(t, -k).tolist()) for t in triangles for k in range(3)}


@pytest.mark.parametrize("spread", [0.0, 0.5])
def test_springs_that_join_the_same_points_all_count(spread: float) -> None:
    def pull(pairs: list[list[int]], **options: Any) -> npt.NDArray[np.float32]:
        springs = gx.Springs([[0, 0, 0], [1, 0, 0]], springs=pairs, mass=1.0, damping=0.1, **options)
        return springs.simulate(0.3, gravity=(0, 0, 0), substeps=20)[-1]

    part = np.linspace(1.0 - spread, 1.0 + spread, 70_000)  # more than some drivers let a loop run
    alone = pull([[0, 1]], stiffness=6.0, rest=0.5)
    np.testing.assert_allclose(pull([[0, 1], [1, 0]], stiffness=3.0, rest=0.5), alone, rtol=1e-6)
    np.testing.assert_allclose(pull([[0, 1]] * 3, stiffness=[1, 2, 3], rest=[0.3, 0.4, 1.9 / 3]), alone, rtol=1e-6)
    np.testing.assert_allclose(pull([[0, 1]] * 2, stiffness=0.0, rest=0.5), [[0, 0, 0], [1, 0, 0]])
    many = pull([[0, 1]] * len(part), stiffness=6.0 / len(part), rest=0.5 * part)
    np.testing.assert_allclose(many, alone, rtol=1e-6)


def test_a_point_with_more_springs_than_there_is_room_for_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(incidence, "MAX_LIST_BYTES", 12 * 40 * 32)
    points = np.random.default_rng(0).random((40, 3))
    spokes = np.stack([np.full(39, 7), np.delete(np.arange(40), 7)], axis=1)
    message = r"^springs must be at most 32 per point, as 40 points have room for as many each, got 39 for point 7$"
    with pytest.raises(gx.ArgumentError, match=message):
        gx.Springs(points, springs=spokes, stiffness=np.arange(1.0, 40.0), mass=1.0)
