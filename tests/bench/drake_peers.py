"""Drake on arms and trees of rigid links: time to equal error, by all of its integrators.

    python tests/bench/drake_peers.py [arm:12 tree:15 ..]

Rules: Drake has the same boxes, hinges, friction and weight (`growing.py`) as a continuous
`MultibodyPlant`, without geometry and contact. Each of its integrators runs over a ladder of
accuracies (of steps, where it has no error control); ours is the default of the model, over a
ladder of rtol. The error is the largest of the joints' speeds in any of 21 rows, over the largest
speed, against a third solution: Pinocchio's ABA by SciPy's DOP853 at 1e-13. Drake's time is that of
one call of `AdvanceTo`, which no row interrupts; preparing and initialising do not count. Times are
processor time, the least of several rounds in which all runs take turns. Time to an error is that
of the cheapest run that reaches it: Drake's is that of its quickest integrator.
"""

from __future__ import annotations

import sys
from functools import cache, partial
from importlib.util import find_spec
from time import thread_time
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from arm_peers import Boxes
from factorisation import lowered_model
from growing import CENTRE, FRICTION, INERTIA, LINK
from growth import Solve, Timed, cheapest, default, instance_of, solved
from scipy.integrate import solve_ivp
from table import Row, pin

from bgc.runtime.results.arrays import Array

if TYPE_CHECKING:
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.multibody.tree import RevoluteJoint
    from pydrake.systems.framework import Context

_ARMS = ("arm:6", "arm:12")
_TARGETS = (1e-3, 1e-4, 1e-6, 1e-8, 1e-9)
_ACCURACIES = tuple(10.0 ** (-k / 2) for k in range(2, 29))
_EQUAL = 1e-9  # errors of the tightest runs of ours and of Drake
_END, _ROUNDS = 1.0, 3  # s
_LONG = 0.25  # s of processor time, after which an integrator gets no smaller accuracy
_STEPS = ("explicit_euler", "semi_explicit_euler", "runge_kutta2")  # without error control
_LARGEST_STEP = 0.1  # s, Drake's default


class Runs(NamedTuple):
    """The runs of ours and of each of Drake's integrators, and errors of the tightest of both."""

    ours: list[Timed]
    drake: dict[str, list[Timed]]
    our_least: float
    drake_least: float

    @property
    def any_of_drake(self) -> list[Timed]:
        return [run for runs in self.drake.values() for run in runs]


class Drake:
    """A mechanism in Drake, alone or in a diagram."""

    def __init__(self, boxes: Boxes, in_diagram: bool = False) -> None:
        from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
        from pydrake.systems.analysis import Simulator
        from pydrake.systems.framework import DiagramBuilder

        self._boxes = boxes
        if in_diagram:
            builder = DiagramBuilder()
            self._plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
        else:
            self._plant = MultibodyPlant(time_step=0.0)
        self._joints = _add_boxes(self._plant, boxes)
        self._simulator = Simulator(builder.Build() if in_diagram else self._plant)

    def run(self, integrator: str, accuracy: float, times: Array) -> tuple[float, Array, int]:
        """Seconds, rows and steps of a run that stops at each of the times."""
        from pydrake.systems.analysis import ResetIntegratorFromFlags

        simulator = self._simulator
        ResetIntegratorFromFlags(simulator, integrator, _LARGEST_STEP)
        control = simulator.get_mutable_integrator()
        if integrator in _STEPS:
            control.set_maximum_step_size(accuracy)
        else:
            control.set_fixed_step_mode(False)
            control.set_target_accuracy(accuracy)
        context = simulator.get_mutable_context()
        context.SetTime(times[0])
        own = self._plant.GetMyMutableContextFromRoot(context)
        for joint, angle, rate in zip(self._joints, self._boxes.q, self._boxes.v, strict=True):
            joint.set_angle(own, angle)
            joint.set_angular_rate(own, rate)
        simulator.Initialize()
        rows, seconds = [self._speeds(own)], 0.0
        for time in times[1:]:
            begun = thread_time()
            simulator.AdvanceTo(time)
            seconds += thread_time() - begun
            rows.append(self._speeds(own))
        return seconds, np.array(rows), int(control.get_num_steps_taken())

    def _speeds(self, context: Context) -> list[float]:
        return [joint.get_angular_rate(context) for joint in self._joints]

    def solve(self, integrator: str, times: Array, accuracy: float) -> tuple[float, Array, int]:
        """Seconds and steps of a run to the end, and rows of another that stops at them."""
        try:
            rows = self.run(integrator, accuracy, times)[1]
            seconds, _, steps = self.run(integrator, accuracy, times[[0, -1]])
        except RuntimeError:  # its steps became too small
            return np.inf, np.full((len(times), len(self._joints)), np.inf), 0
        return seconds, rows, steps


def _add_boxes(plant: MultibodyPlant, boxes: Boxes) -> list[RevoluteJoint]:
    """Add the boxes to an empty plant; their joints, by number."""
    from pydrake.math import RigidTransform
    from pydrake.multibody.tree import (
        FixedOffsetFrame,
        RevoluteJoint,
        RotationalInertia,
        SpatialInertia,
    )

    (xx, xy, xz), (_, yy, yz), (_, _, zz) = INERTIA
    about_centre = RotationalInertia(xx, yy, zz, xy, xz, yz)
    bodies, joints = [], []
    for k, (parent, mass) in enumerate(zip(boxes.parent, boxes.mass, strict=True)):
        inertia = SpatialInertia.MakeFromCentralInertia(mass, CENTRE, about_centre)
        bodies.append(plant.AddRigidBody(f"box{k}", inertia))
        before = bodies[parent] if parent >= 0 else plant.world_body()
        place = RigidTransform([LINK if parent >= 0 else 0.0, 0.0, 0.0])
        frame = plant.AddFrame(FixedOffsetFrame(f"mount{k}", before.body_frame(), place))
        axis = [float(each == boxes.axis[k]) for each in "xyz"]
        joint = RevoluteJoint(f"joint{k}", frame, bodies[k].body_frame(), axis, FRICTION)
        joints.append(plant.AddJoint(joint))
    plant.Finalize()
    return joints


def reference(boxes: Boxes, times: Array) -> Array:
    """The joints' speeds by Pinocchio and SciPy, rad/s, of shape (times, joints)."""
    import pinocchio

    model = pinocchio.Model()
    kinds = {"x": pinocchio.JointModelRX, "y": pinocchio.JointModelRY, "z": pinocchio.JointModelRZ}
    added: list[int] = []
    for k, (parent, mass) in enumerate(zip(boxes.parent, boxes.mass, strict=True)):
        before = added[parent] if parent >= 0 else 0
        place = pinocchio.SE3(np.eye(3), np.array([LINK if before else 0.0, 0.0, 0.0]))
        added.append(model.addJoint(before, kinds[boxes.axis[k]](), place, f"joint{k}"))
        inertia = pinocchio.Inertia(mass, np.array(CENTRE), np.array(INERTIA))
        model.appendBodyToJoint(added[k], inertia, pinocchio.SE3.Identity())
    data, count = model.createData(), model.nv
    order = np.array([model.idx_vs[each] for each in added])

    def slope(_: float, x: Array) -> Array:
        q, v = x[:count], x[count:]
        return np.concatenate([v, pinocchio.aba(model, data, q, v, -FRICTION * v)])

    start = np.empty(2 * count)
    start[order], start[count + order] = boxes.q, boxes.v
    span = (times[0], times[-1])
    done = solve_ivp(slope, span, start, "DOP853", times, rtol=1e-13, atol=1e-13)
    return np.array(done.y[count + order].T)


@cache
def measure(name: str, least: float = _TARGETS[-1]) -> Runs | str:
    """The runs of ours and of all integrators of Drake down to an error, or why there are none."""
    if find_spec("pydrake") is None or find_spec("pinocchio") is None:
        return "pip install drake pin"
    from pydrake.systems.analysis import GetIntegrationSchemes

    boxes, times = Boxes.of(name), np.linspace(0.0, _END, 21)
    made = instance_of(lowered_model(name))
    ways: dict[str, Solve] = {"": partial(solved, made, times, default(made))}
    peer, in_diagram = Drake(boxes), Drake(boxes, in_diagram=True)
    for integrator in GetIntegrationSchemes():
        system = in_diagram if integrator == "cenic" else peer  # it runs in diagrams only
        ways[integrator] = partial(system.solve, integrator, times)

    exact = reference(boxes, times)
    tightest = solved(made, times, "dopri5", 1e-12)[1], peer.solve("runge_kutta5", times, 1e-13)[1]
    apart = [float(np.abs(end - exact).max() / np.abs(exact).max()) for end in tightest]
    assert max(apart) < _EQUAL, f"{name}: ours and Drake's differ from the reference by {apart}"
    found = _in_turn(ways, exact, least)
    return Runs(found.pop(""), found, *apart)


def _in_turn(ways: dict[str, Solve], exact: Array, least: float) -> dict[str, list[Timed]]:
    """The runs of each way down the ladder, with the least times of all rounds."""
    found: dict[str, dict[float, Timed]] = {way: {} for way in ways}
    size = np.abs(exact).max()
    for _ in range(_ROUNDS):
        for way, solve in ways.items():
            for accuracy in _ACCURACIES:
                seconds, rows_, steps = solve(accuracy)
                error = float(np.abs(rows_ - exact).max() / size)
                before = found[way].get(accuracy, Timed(error, np.inf, steps))
                found[way][accuracy] = Timed(error, min(seconds, before.seconds), steps)
                if error < 0.1 * least or seconds > _LONG:
                    break
    return {way: list(runs.values()) for way, runs in found.items()}


def rows() -> list[Row]:
    """Times of Drake over ours to equal errors."""
    made = []
    for name in _ARMS:
        runs = measure(name)
        if isinstance(runs, str):
            made.append(Row("Drake", name, None, note=runs))
            continue
        for target in _TARGETS:
            own = cheapest(target, runs.ours).seconds
            which, theirs = _quickest(target, runs)
            note = f"{1e3 * theirs:.2f} ms ({which}) against {1e3 * own:.3f} ms"
            made.append(Row("Drake", f"{name}, to {target:.0e}", theirs / own, note=note))
    return made


def _quickest(target: float, runs: Runs) -> tuple[str, float]:
    """The integrator of Drake that reaches an error first, and its seconds."""
    times = {which: cheapest(target, found).seconds for which, found in runs.drake.items()}
    which = min(times, key=lambda each: times[each])
    return which, times[which]


def _print(name: str) -> None:
    runs = measure(name)
    if isinstance(runs, str):
        raise SystemExit(runs)
    apart = f"at their tightest {runs.our_least:.0e} and {runs.drake_least:.0e} off"
    print(f"{name}: error and ms of each accuracy; ours and Drake are {apart}")
    for way, found in {"ours": runs.ours, **runs.drake}.items():
        print(f"  {way:24}", *(f"{error:.0e} {1e3 * s:.2f}," for error, s, _ in found))
    for target in _TARGETS:
        own = cheapest(target, runs.ours).seconds
        which, theirs = _quickest(target, runs)
        print(f"  to {target:.0e}: ours {1e3 * own:.3f} ms, {which} {theirs / own:.1f} times that")


if __name__ == "__main__":
    pin()
    for mechanism in sys.argv[1:] or _ARMS:
        _print(mechanism)
