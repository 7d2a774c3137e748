"""Cylindrical, screw, planar and universal joints against Lagrange's equations, and their locks."""

import numpy as np
import pytest
from lagrange import motion
from scipy.spatial.transform import Rotation

QUAY = Rotation.from_euler("ZYX", [0.5, -0.3, 0.2]).as_matrix()
PLACE = np.array([1.0, 2, 3])
MASS, COM = 20.0, np.array([0.3, -0.1, 0.2])
INERTIA = np.array([[4, 0.3, -0.2], [0.3, 2.5, 0.4], [-0.2, 0.4, 1.5]])


def turn(axis, angle):
    """Rodrigues' matrix, for complex angles too."""
    skew = np.cross(np.eye(3), axis)
    return np.eye(3) + np.sin(angle) * skew + (1 - np.cos(angle)) * skew @ skew


class Cylindrical:
    axis, drives = QUAY @ [0.6, 0, 0.8], np.array([30.0, 120])
    start, rates = np.array([0.2, 0.1]), np.array([0.5, 0.3])

    def pose(self, q):
        return PLACE + self.axis * q[1], turn(self.axis, q[0]) @ QUAY

    def slopes(self, _, arm):
        zero = 0 * self.axis
        return [np.cross(self.axis, arm), self.axis], [self.axis, zero]


class Screw:
    axis, drives = QUAY @ [0.6, 0, -0.8], np.array([30.0])
    start, rates = np.array([0.2]), np.array([0.5])
    lead = 0.5 / (2 * np.pi)

    def pose(self, q):
        return PLACE + self.axis * q[0] * self.lead, turn(self.axis, q[0]) @ QUAY

    def slopes(self, _, arm):
        return [np.cross(self.axis, arm) + self.lead * self.axis], [self.axis]


class Planar:
    drives = np.array([50.0, -80, 30])
    start, rates = np.array([0.1, 0.2, 0.2]), np.array([0.3, -0.4, 0.5])

    def pose(self, q):
        return PLACE + QUAY @ [q[0], q[1], 0 * q[0]], turn(QUAY[:, 2], q[2]) @ QUAY

    def slopes(self, _, arm):
        x, y, z = QUAY.T
        return [x, y, np.cross(z, arm)], [0 * x, 0 * x, z]


class Universal:
    first, drives = QUAY @ [0.6, 0, -0.8], np.array([10.0, -5])
    start, rates = np.array([0.3, -0.4]), np.array([0.5, 0.7])

    def second(self, q):
        return turn(self.first, q[0]) @ QUAY[:, 1]

    def pose(self, q):
        return PLACE + 0 * q[0], turn(self.second(q), q[1]) @ turn(self.first, q[0]) @ QUAY

    def slopes(self, q, arm):
        axes = [self.first, self.second(q)]
        return [np.cross(axis, arm) for axis in axes], axes


def reference(joint, times):
    def mass(q):
        _, turned = joint.pose(q)
        shifts, spins = (np.array(part).T for part in joint.slopes(q, turned @ COM))
        world = turned @ INERTIA @ turned.T
        return MASS * shifts.T @ shifts + spins.T @ world @ spins

    def potential(q):
        place, turned = joint.pose(q)
        return MASS * 9.81 * (place + turned @ COM)[2] - joint.drives @ q

    q, _ = motion(mass, potential, joint.start, joint.rates, times)
    return q, np.array([joint.pose(row)[0] for row in q])


JOINTS = {
    "cylindrical": (Cylindrical(), ["q", "s"]),
    "screw": (Screw(), ["q"]),
    "planar": (Planar(), ["s", "q"]),
    "universal": (Universal(), ["q"]),
}


@pytest.mark.parametrize("lock", ["", "soft_"])
@pytest.mark.parametrize("name", list(JOINTS))
def test_a_joint_moves_as_lagrange_says(load, name, lock):
    joint, columns = JOINTS[name]
    result = load("pairs", lock + name).simulate(rtol=1e-8)
    q, place = reference(joint, result.time)
    found = np.column_stack([result[column] for column in columns])
    bound = 2e-2 if lock else 1e-6  # the default lock gives way by micrometres, and rings a little
    np.testing.assert_allclose(found, q, atol=bound)
    np.testing.assert_allclose(result["r"], place, atol=bound)
    assert np.abs(result["energy.residual"]).max() < 1e-6 * result.counts["exchanged"]


def test_drives_at_the_ports_of_joints_are_those_inside(load):
    """The sign of each port, and a body without mass that takes no part."""
    result = load("pairs", "powered").simulate()
    assert np.ptp(result["moved"], axis=0).min() > 0.5
    assert np.abs(result["apart"]).max() < 1e-12
    assert np.abs(result["energy.residual"]).max() < 1e-6 * result.counts["exchanged"]
    assert not result["nothing"].any()
