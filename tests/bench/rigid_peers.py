"""MuJoCo and Pinocchio on the crane with rigid joints, against the reduced f and fixed steps.

Rules: the peers' crane has the same bodies, joints, weights and drives (still springs, and
friction; Pinocchio has given torques instead), and no water. No contacts, no constraints, no
sensors. All are called in loops in C (Pinocchio: C++ with -O3 and its fixed joint types) from
moving states; ours is the whole right-hand side, water included. Each time is the least of several
batches, ours the median over fresh copies, those of steps in turn with the peer's.

The springs: a bar falls from level on a pivot of stiff springs, undamped, at a step of 1 ms.
The stiffness rises until the angle is 1 % off; omega is the fastest mode's frequency. MuJoCo
has the same springs as joints.
"""

from __future__ import annotations

from collections.abc import Callable
from ctypes import POINTER, c_double, c_int, c_void_p
from importlib.util import find_spec
from pathlib import Path
from statistics import median

import numpy as np
from crane import copies, crane, instance, run, shared_object
from kernels import median_times, step_time
from table import Row

from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Library
from bgc.runtime.running.structures import Status

_Doubles = POINTER(c_double)
_CALLS, _BATCHES = 2000, 15

_CRANE = """<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.001" integrator="{integrator}">
    <flag contact="disable" constraint="disable"/>
  </option>
  <worldbody><body><freejoint/>
    <inertial pos="0 0 0" mass="1e5" diaginertia="7e5 3.6e6 4.1e6"/>
    <body pos="2 0 1.5"><joint axis="0 0 1" stiffness="2e6" damping="1e5"/>
      <inertial pos="0 0 2" mass="5e3" diaginertia="7.5e3 7.5e3 1.5e3"/>
      <body pos="0 0 4"><joint axis="0 1 0" stiffness="3e6" damping="1e5"/>
        <inertial pos="4 0 0" mass="3e3" diaginertia="4e2 1.65e4 1.65e4"/>
        <body pos="8 0 0"><joint axis="0 1 0" stiffness="1e6" damping="2e4"/>
          <inertial pos="3 0 0" mass="1.5e3" diaginertia="1.2e2 4.6e3 4.6e3"/>
  </body></body></body></body></worldbody>
</mujoco>"""
_PENDULUM = """<mujoco>
  <compiler angle="radian"/>
  <option timestep="0.001" integrator="{integrator}">
    <flag contact="disable" constraint="disable"/>
  </option>
  <worldbody><body>
    <joint type="slide" axis="1 0 0" stiffness="{k}"/>
    <joint type="slide" axis="0 1 0" stiffness="{k}"/>
    <joint type="slide" axis="0 0 1" stiffness="{k}"/>
    <joint axis="1 0 0" stiffness="{turn}"/>
    <joint axis="0 0 1" stiffness="{turn}"/>
    <joint axis="0 1 0"/>
    <inertial pos="3 0 0" mass="1.5e3" diaginertia="1.2e2 4.6e3 4.6e3"/>
  </body></worldbody>
</mujoco>"""
_STEP, _FALL = 1e-3, 2.0


def rows() -> list[Row]:
    """Pinocchio's ABA, mj_forward, mj_step, and joint springs."""
    f = median_times("reduced_still")[0]
    return [_pinocchio(f), *_mujoco(f)]


def _pinocchio(f: float) -> Row:
    name, on = "Pinocchio ABA (C++)", "reduced f, nv = 9"
    spec = find_spec("cmeel")
    flags = ["-O3", "-DNDEBUG", "-std=c++17", "-I/usr/include/eigen3"]
    flags += ["-DBOOST_MPL_LIMIT_LIST_SIZE=30", "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS"]
    if spec is not None and spec.origin is not None:
        prefix = Path(spec.origin).parents[1] / "cmeel.prefix"
        flags += [f"-I{prefix / 'include'}", f"-L{prefix / 'lib'}", f"-Wl,-rpath,{prefix / 'lib'}"]
    peer = shared_object(["aba.cpp"], [*flags, "-lpinocchio_default"], "c++")
    if isinstance(peer, str):
        return Row(name, on, None, 4, 6, note=f"{peer} (pip install pin; libeigen3-dev)")
    peer.aba_seconds.restype = c_double
    q = np.array([0, 0, 0, 0, 0, 0, 1, 0.1, 0.2, 0.3])
    v, a = np.linspace(-0.2, 0.2, 9), np.zeros(9)
    pointers = [x.ctypes.data_as(_Doubles) for x in (q, v)]
    seconds = min(
        peer.aba_seconds(*pointers, _CALLS, _BATCHES, a.ctypes.data_as(_Doubles)) for _ in range(3)
    )
    note = f"{1e6 * seconds:.2f} us against {1e6 * f:.2f} us"
    return Row(name, on, seconds / f, 4, 6, note=note)


def _mujoco(f: float) -> list[Row]:
    names = ("MuJoCo mj_forward", "MuJoCo mj_step implicitfast", "MuJoCo joint springs")
    try:
        import mujoco
    except ImportError:
        return [Row(name, "crane", None, note="pip install mujoco") for name in names]
    folder = Path(mujoco.__file__).parent
    library = next(folder.glob("libmujoco.*"))
    flags = [f"-I{folder / 'include'}", str(library), f"-Wl,-rpath,{folder}"]
    peer = shared_object(["mujoco_clock.c", "clock.c"], flags)
    if isinstance(peer, str):
        return [Row(name, "crane", None, note=peer) for name in names]
    mujoco.set_mju_user_warning(lambda _: None)  # unstable runs are looked for
    model = mujoco.MjModel.from_xml_string(_CRANE.format(integrator="implicitfast"))
    data = mujoco.MjData(model)
    data.qvel[:] = np.linspace(-0.2, 0.2, 9)
    seconds = (c_double * 2)()
    peer.mujoco_seconds.argtypes = (c_void_p, c_void_p, c_int, c_int, _Doubles)
    peer.mujoco_seconds(model._address, data._address, _CALLS, _BATCHES, seconds)
    found = [Row(names[0], "reduced f", seconds[0] / f, 8, 12, note=f"{1e6 * seconds[0]:.2f} us")]
    for method, keep, must, aim in (
        ("ros23", 1, 2.0, None), ("ros23", 5, None, 0.5), ("ros34prw", 1, None, None),
        ("ros34prw", 5, None, None),
    ):  # fmt: skip
        pairs = []
        with copies(crane("near_rigid_still").path) as libraries:
            for one in libraries:  # in turn, so that both see the same machine
                peer.mujoco_seconds(model._address, data._address, 500, _BATCHES, seconds)
                pairs.append((step_time(one, method, keep=keep), seconds[1]))
        ratio = median(ours / theirs for ours, theirs in pairs)
        kept = f", J kept {keep} steps" if keep > 1 else ""
        note = "{:.2f} us against {:.2f} us".format(
            *(1e6 * min(x) for x in zip(*pairs, strict=True))
        )
        found.append(Row(names[1], f"70 states, {method}{kept}", ratio, must, aim, True, note))
    return [*found, _springs(names[2], mujoco)]


def _springs(name: str, mujoco: object) -> Row:
    times = np.linspace(0.0, _FALL, 201)
    with copies(crane("fall", "pendulum.bg").path, 1) as libraries:
        library = libraries[0]
        exact = _our_fall(library, 1e12, times, "rodas5p", 1e-9)
        size = np.abs(exact).max()

        def largest(fall: Callable[[float], Array]) -> float:
            good = 0.0
            for k in 10.0 ** np.arange(5.0, 20.01, 0.1):
                angle = fall(k)
                # Soft springs sag: only stiffer ones than that can be judged.
                if k > 1e7 and not np.abs(angle - exact).max() < 0.01 * size:
                    break
                good = k
            return good

        ours = largest(lambda k: _our_fall(library, k, times, "ros34prw", 0.0))
        best, which = 0.0, ""
        for integrator in ("Euler", "implicit", "implicitfast", "RK4"):
            theirs = largest(lambda k: _their_fall(mujoco, integrator, k, times))  # noqa: B023
            if theirs > best:
                best, which = theirs, integrator
        limits = [_STEP * _fastest(library, k) for k in (ours, best)]
    note = f"h omega {limits[0]:.2g} against {limits[1]:.2f} ({which}, its best)"
    return Row(name, "largest h omega, 1 % off", limits[0] / limits[1], 100, 1000, note=note)


def _our_fall(library: Library, k: float, times: Array, method: str, rtol: float) -> Array:
    made = instance(library, stiffness=k)
    status, rows_, _ = run(made, times, method, rtol=rtol, step=0.0 if rtol else _STEP)
    return rows_[:, 0] if status is Status.OK else np.full(len(times), np.nan)


def _their_fall(mujoco: object, integrator: str, k: float, times: Array) -> Array:
    text = _PENDULUM.format(integrator=integrator, k=k, turn=10 * k)
    model = mujoco.MjModel.from_xml_string(text)  # type: ignore[attr-defined]
    data = mujoco.MjData(model)  # type: ignore[attr-defined]
    angle = np.full(len(times), np.nan)
    each = round((times[1] - times[0]) / _STEP)
    angle[0] = 0.0
    for row in range(1, len(times)):
        mujoco.mj_step(model, data, each)  # type: ignore[attr-defined]
        if data.time < times[row] - 0.5 * _STEP:
            break  # unstable: it has started again
        angle[row] = data.qpos[5]
    return angle


def _fastest(library: Library, k: float) -> float:
    made = instance(library, stiffness=k)
    _, jacobian, _ = made.jacobian()
    return float(np.abs(np.linalg.eigvals(jacobian).imag).max())
