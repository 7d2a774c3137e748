"""Accelerations of the library's crane with rigid joints, at random states, in three other ways."""

from dataclasses import fields
from functools import cache

import numpy as np
import pytest
from crane_references import ByMujoco, ByPinocchio, State, by_energies, crane_of, skew
from probe import Probe, probe

STATES = 1000
VELOCITIES = (*(f"twist[{k}]" for k in range(1, 7)), "slew", "luff", "fold")
SPREAD = np.array([2, 2, 2, 0.3, 0.3, 0.3, 1, 1, 1])  # m/s, rad/s


def quaternion_matrix(h):
    cross = skew(h[1:])
    return np.eye(3) + 2 * h[0] * cross + 2 * cross @ cross


@cache
def random_states():
    """Every orientation of the hull and every angle; fast, pushed and steered."""
    rng = np.random.default_rng(2013)
    states = []
    for _ in range(STATES):
        quaternion = rng.normal(size=4)
        quaternion /= np.linalg.norm(quaternion)
        state = State(
            orientation=quaternion_matrix(quaternion),
            angles=rng.uniform(-np.pi, np.pi, 3),
            velocities=rng.normal(size=9) * SPREAD,
            push=rng.normal(size=6) * np.repeat([2e4, 1e5], 3),
            steering=rng.normal(size=3) * 2e4,
        )
        states.append((quaternion, state))
    return states


@cache
def crane() -> Probe:
    return probe("rigid_crane", "afloat", *VELOCITIES)


def without_water():
    names = (name for name in crane().model.parameters if name.startswith("vessel.M_A["))
    return dict.fromkeys(names, 0.0)


def accelerations(quaternion, state, parameters):
    declared = {f"vessel.pose.attitude.h[{k}]": x for k, x in enumerate(quaternion, 1)}
    joints = ("crane.pedestal.angle", "crane.shoulder.angle", "crane.elbow.angle")
    declared |= dict(zip(joints, state.angles, strict=True))
    for name in ("push", "steering"):
        values = getattr(state, name)
        parameters = parameters | {f"{name}[{k}]": x for k, x in enumerate(values, 1)}
    at = crane().at(declared, state.velocities, parameters)
    return crane().accelerations(at, parameters)


def deviation(reference, parameters):
    """The largest difference of a component, in parts of its root mean square."""
    found = np.array([accelerations(*at, parameters) for at in random_states()])
    expected = np.array([reference(state) for _, state in random_states()])
    scale = np.sqrt((expected**2).mean(axis=0))
    return (np.abs(found - expected) / scale).max()


def data(parameters):
    known = crane().model.parameters
    return crane_of({name: p.value for name, p in known.items()} | parameters)


@pytest.mark.parametrize("reference", [ByPinocchio, ByMujoco])
def test_accelerations_without_added_mass(reference):
    if reference is ByPinocchio:
        pytest.importorskip("pinocchio")
    dry = without_water()
    assert deviation(reference(data(dry)), dry) < 1e-10


def test_accelerations_with_added_mass():
    """The whole M_A, by Kirchhoff's equations."""
    wet = data({})
    assert np.count_nonzero(wet.added) > 9, "more than a diagonal"
    assert deviation(lambda state: by_energies(wet, state), {}) < 1e-10


def test_the_states_reach_far():
    quaternions, states = zip(*random_states(), strict=True)
    assert all(np.isfinite(getattr(s, f.name)).all() for s in states for f in fields(s))
    assert np.ptp(quaternions, axis=0).min() > 1.5
