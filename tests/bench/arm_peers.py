"""MuJoCo and Pinocchio on arms and trees of rigid links, against the compiled f, J and fixed steps.

    python tests/bench/arm_peers.py [arm:12 tree:15 ..]

Rules: the same boxes, hinges, friction and weight (`growing.py`). All accelerations agree to 1e-6
at the start (ours by differences along f), or the comparison ends. No contacts, no constraints, no
sensors. All are called in loops in C (Pinocchio: C++ with -O3 and its fixed joint types) from the
same moving state; each time is the least of several batches of processor time. Pinocchio has the
whole right-hand side and its derivatives (`computeABADerivatives`), MuJoCo steps of 1 ms:
`implicitfast` and `implicit`, of order one, beside ours of order three: the default with a step
(`switching_fixed`: rk4 while it resolves all motions), and `ros34prw` alone. CasADi has the same
equations (`casadi_code.py`).
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from ctypes import CDLL, POINTER, c_double, c_int, c_void_p
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import casadi_code
import numpy as np
from crane import copies, instance, shared_object
from factorisation import lowered_model
from growing import CENTRE, FRICTION, INERTIA, LINK, box
from kernels import kernel_times, step_time
from table import Row, pin

from bgc.building.build import build_shared_object
from bgc.building.cache import open_cache
from bgc.building.toolchain import find_toolchain
from bgc.emission.emit import emit_lowered
from bgc.language.methods import SWITCHING_FIXED
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Library
from bgc.runtime.running.structures import Status

_Doubles, _Ints = POINTER(c_double), POINTER(c_int)
_BATCHES = 15
_CASADI = (24, 8)  # most joints of f, and of J, whose C then takes seconds of the C compiler
_PARENTS: dict[str, Callable[[int], int]] = {
    "arm": lambda k: k - 1,
    "tree": lambda k: (k - 1) // 2 if k else -1,
}

# What a peer's time over ours has to reach: (must, aim) of ABA, and of both kinds of steps.
_GOALS: dict[str, tuple[tuple[float, float], tuple[float, float], tuple[float, float]]] = {
    "arm:6": ((6, 8), (1, 1.2), (1.5, 2.5)),
    "arm:12": ((3.6, 5), (0.45, 1), (1.5, 2.5)),
    "arm:24": ((3, 5), (0.4, 1), (1.5, 2.5)),
    "arm:48": ((3, 5), (0.4, 1), (1.5, 2.5)),
}


@dataclass(frozen=True)
class Boxes:
    """The numbers of a mechanism of `growing.py`, for the peers."""

    parent: list[int]
    axis: list[str]
    q: Array
    v: Array
    mass: Array

    @classmethod
    def of(cls, name: str) -> Boxes:
        kind, _, size = name.partition(":")
        axes, q, v, mass = zip(*(box(k) for k in range(int(size))), strict=True)
        parent = [_PARENTS[kind](k) for k in range(int(size))]
        return cls(parent, list(axes), np.array(q), np.array(v), np.array(mass))

    @property
    def calls(self) -> int:
        """Calls of a batch: a few milliseconds of any of them."""
        return max(50, 6000 // len(self.q))


@dataclass(frozen=True)
class Ours:
    """Seconds of f, J and steps, and the accelerations at the start."""

    f: float
    jacobian: float
    step: float  # of the default method
    implicit_step: float
    accelerations: Array


def ours(name: str) -> Ours:
    """The compiled mechanism: the median of three copies."""
    units = emit_lowered(lowered_model(name), "").units
    path = build_shared_object(units, find_toolchain(), open_cache())
    with copies(path, 3) as libraries:
        calls = Boxes.of(name).calls
        kernels = [kernel_times(one, calls, _BATCHES) for one in libraries]
        f, jacobian, *_ = (sorted(column)[1] for column in zip(*kernels, strict=True))
        step, implicit = (
            sorted(step_time(one, method) for one in libraries)[1]
            for method in (SWITCHING_FIXED, "ros34prw")
        )
        return Ours(f, jacobian, step, implicit, _accelerations(libraries[0]))


def _accelerations(library: Library) -> Array:
    """Rates of the observed speeds at the start, by differences along f."""
    made = instance(library)
    status, slope = made.rhs()
    assert status is Status.OK
    start, step, found = made.state.copy(), 1e-6, []
    for sign in (1, -1):
        made.state[:] = start + sign * step * slope
        found.append(made.outputs()[1])
    return (found[0] - found[1]) / (2 * step)


def pinocchio(name: str) -> tuple[float, float, Array] | str:
    """Seconds of ABA and of its derivatives and the accelerations, or why there are none."""
    peer = _pinocchio()
    if isinstance(peer, str):
        return peer
    boxes = Boxes.of(name)
    count = len(boxes.q)
    parent = (c_int * count)(*boxes.parent)
    axis = (c_int * count)(*("xyz".index(each) for each in boxes.axis))
    arrays = [boxes.mass, np.array(CENTRE), np.array(INERTIA), boxes.q, boxes.v]
    mass, com, inertia, q, v = (each.ctypes.data_as(_Doubles) for each in arrays)
    a, seconds = np.zeros(count), (c_double * 2)()
    peer.arm_seconds(
        count, parent, axis, mass, c_double(LINK), com, inertia, c_double(FRICTION), q, v,
        boxes.calls, _BATCHES, a.ctypes.data_as(_Doubles), seconds,
    )  # fmt: skip
    return seconds[0], seconds[1], a


@cache
def _pinocchio() -> CDLL | str:
    spec = find_spec("cmeel")
    flags = ["-O3", "-DNDEBUG", "-std=c++17", "-I/usr/include/eigen3"]
    flags += ["-DBOOST_MPL_LIMIT_LIST_SIZE=30", "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS"]
    if spec is not None and spec.origin is not None:
        prefix = Path(spec.origin).parents[1] / "cmeel.prefix"
        flags += [f"-I{prefix / 'include'}", f"-L{prefix / 'lib'}", f"-Wl,-rpath,{prefix / 'lib'}"]
    clock = shared_object(["clock.c"])
    if isinstance(clock, str):
        return clock
    flags += ["-lpinocchio_default", clock._name, f"-Wl,-rpath,{Path(clock._name).parent}"]
    return shared_object(["arm.cpp"], flags, "c++")


def mujoco(name: str, integrator: str) -> tuple[float, float, Array] | str:
    """Seconds of mj_forward and mj_step and the accelerations, or why there are none."""
    try:
        import mujoco
    except ImportError:
        return "pip install mujoco"
    folder = Path(mujoco.__file__).parent
    library = next(folder.glob("libmujoco.*"))
    flags = [f"-I{folder / 'include'}", str(library), f"-Wl,-rpath,{folder}"]
    peer = shared_object(["mujoco_clock.c", "clock.c"], flags)
    if isinstance(peer, str):
        return peer
    boxes = Boxes.of(name)
    model = mujoco.MjModel.from_xml_string(_xml(boxes, integrator))
    data = mujoco.MjData(model)
    order = [model.joint(f"joint{k}").dofadr[0] for k in range(len(boxes.q))]
    data.qpos[order], data.qvel[order] = boxes.q, boxes.v
    mujoco.mj_forward(model, data)
    accelerations = data.qacc[order].copy()
    seconds = (c_double * 2)()
    peer.mujoco_seconds.argtypes = (c_void_p, c_void_p, c_int, c_int, _Doubles)
    peer.mujoco_seconds(model._address, data._address, boxes.calls, _BATCHES, seconds)
    return seconds[0], seconds[1], accelerations


def _xml(boxes: Boxes, integrator: str) -> str:
    """The mechanism in MuJoCo's words, without limits and contacts."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = INERTIA
    inertia = f"{xx} {yy} {zz} {xy} {xz} {yz}"

    def body(k: int) -> str:
        place = LINK if boxes.parent[k] >= 0 else 0
        axis = " ".join("1" if each == boxes.axis[k] else "0" for each in "xyz")
        inside = "".join(body(other) for other, parent in enumerate(boxes.parent) if parent == k)
        return (
            f'<body pos="{place} 0 0">'
            f'<joint name="joint{k}" type="hinge" axis="{axis}" damping="{FRICTION}"/>'
            f'<inertial pos="{" ".join(map(str, CENTRE))}" mass="{boxes.mass[k]}"'
            f' fullinertia="{inertia}"/>{inside}</body>'
        )

    roots = "".join(body(k) for k, parent in enumerate(boxes.parent) if parent < 0)
    return (
        f'<mujoco><option timestep="0.001" integrator="{integrator}" gravity="0 0 -9.81">'
        '<flag contact="disable" constraint="disable"/></option>'
        f"<worldbody>{roots}</worldbody></mujoco>"
    )


def _casadi(name: str) -> tuple[float, ...] | str:
    """Seconds of CasADi's C for f and, of short mechanisms, for J, or why there are none."""
    lowered = lowered_model(name)
    joints = len(Boxes.of(name).q)
    if joints > _CASADI[0]:
        return "its C takes long to compile"
    units = emit_lowered(lowered, "").units
    made = instance(Library(build_shared_object(units, find_toolchain(), open_cache())))
    return casadi_code.measured(lowered.program, made.state.copy(), joints <= _CASADI[1])


def measured(name: str) -> dict[str, float | str]:
    """Seconds by what was measured, or why there are none."""
    own = ours(name)
    found: dict[str, float | str] = {
        "our f": own.f, "our J": own.jacobian,
        "ours, 1 ms": own.step, "ros34prw, 1 ms": own.implicit_step,
    }  # fmt: skip
    peers = {
        ("Pinocchio ABA", "ABA derivatives"): pinocchio(name),
        ("mj_forward", "mj_step implicitfast"): mujoco(name, "implicitfast"),
        ("", "mj_step implicit"): mujoco(name, "implicit"),
    }
    for names, answer in peers.items():
        for k, each in enumerate(names):
            if each:
                found[each] = answer if isinstance(answer, str) else answer[k]
        if not isinstance(answer, str):
            apart = np.abs(answer[2] - own.accelerations).max() / np.abs(answer[2]).max()
            assert apart < 1e-6, f"{name}: {names[1]} has other accelerations ({apart:.1e})"
    code = _casadi(name)
    if not isinstance(code, str):
        found |= zip(("CasADi f", "CasADi J"), code, strict=False)
    return found


def rows() -> list[Row]:
    """Times of the peers over ours."""
    made = []
    for name, goals in _GOALS.items():
        found = measured(name)
        pairs = (
            ("Pinocchio ABA", "our f", goals[0]),
            ("ABA derivatives", "our J", (None, None)),
            ("mj_forward", "our f", (None, None)),
            ("mj_step implicitfast", "ours, 1 ms", goals[1]),
            ("mj_step implicit", "ours, 1 ms", goals[2]),
            ("mj_step implicit", "ros34prw, 1 ms", (None, None)),
        )
        for peer, own, (must, aim) in pairs:
            theirs, mine = found[peer], found[own]
            assert not isinstance(mine, str)
            if isinstance(theirs, str):
                made.append(Row(peer, name, None, must, aim, note=theirs))
            else:
                note = f"{1e6 * theirs:.2f} us against {1e6 * mine:.2f} us ({own})"
                made.append(Row(peer, name, theirs / mine, must, aim, note=note))
    return made


if __name__ == "__main__":
    pin()
    for mechanism in sys.argv[1:] or _GOALS:
        print(f"{mechanism}:")
        for what, seconds in measured(mechanism).items():
            print(
                f"  {what:22}", seconds if isinstance(seconds, str) else f"{1e6 * seconds:.2f} us"
            )
