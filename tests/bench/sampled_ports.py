"""Figures of the sampled port and its rivals: `python tests/bench/sampled_ports.py`.

Late peak-to-peak and largest step of the force, by stiffness, resolution, lag and loss, as the
manual has them; with the time that a sample of the port takes.
"""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from bgc import compile
from bgc.runtime.model import Model
from bgc.runtime.running.structures import OptionsStruct

MODELS = Path(__file__).parents[1] / "models" / "sampled_ports.bg"
T, MASS = 1e-3, 0.25
PLAIN = {"tie.damping": 0.0, "tie.brake": 0.0}
STIFFNESSES = (900.0, 1100.0, 2000.0, 5000.0)


def figures(model: Model, **parameters: float) -> str:
    """A cell of the table: late peak-to-peak in um, largest step in N, least energy in uJ."""
    given = {name.replace("__", "."): value for name, value in parameters.items()}
    instance = model.parameters.instance(given)  # also above the limit that a run is refused for
    instance.set_options(OptionsStruct(b"dopri5", rtol=1e-9, atol=0.0, accounts=1))
    instance.reset()
    rows = np.empty((5000, model.row_width))
    instance.run(np.arange(1, 5001) * T, rows)
    result = dict(zip((v.name for v in model.measured), rows.T, strict=False))
    late = 1e6 * np.ptp(result["x"][-1000:])
    step = np.abs(np.diff(result["force"])).max()
    least, owed = 1e6 * result["supplied"].min(), 1e6 * result["owed"].max()
    made = 1e6 * result["energy.created"][-1]
    return f"{late:10.3g} um {step:7.3g} N  E {least:9.3g}  D {owed:7.3g}  C {made:7.3g} uJ"


def alone() -> float:
    """Seconds of processor time of the values that a port alone holds next."""
    model = compile(MODELS, scene="alone")
    instance = model.parameters.instance({})
    instance.reset()
    functions, count = model.library.functions, 100_000
    values, periods = (
        np.empty(64).ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for _ in range(2)
    )

    def spent(call: Callable[..., object], *arguments: object) -> float:
        begin = time.process_time()
        for _ in range(count):
            call(*arguments)
        return (time.process_time() - begin) / count

    where = (model.library.pointer, instance.address, values, periods)
    # The second call does nothing but come from Python.
    return spent(functions.bgc_next_held, *where) - spent(functions.bgc_failed_held, where[1])


def main() -> None:
    """Print all figures."""
    wall, proxy = compile(MODELS, scene="wall"), compile(MODELS, scene="proxy")
    for K in STIFFNESSES:
        k = {"tie.stiffness": K}
        print(f"wall {K:6.0f} plain        {figures(wall, **k, **PLAIN)}")
        print(f"wall {K:6.0f} port         {figures(wall, **k)}")
        print(f"wall {K:6.0f} port 10 um   {figures(wall, **k, hand__resolution=1e-5)}")
        print(f"mass {K:6.0f} port         {figures(proxy, **k)}")
        print(f"wall {K:6.0f} lag 2 as 0   {figures(wall, **k, link__delay=2.0, tie__leak=0.0)}")
        net = {"link.loss": 0.1, "link.jitter": 3.0}
        print(f"wall {K:6.0f} net, 3 K T   {figures(wall, **k, **net, tie__damping=3 * K * T)}")
        print(f"wall {K:6.0f} net, no echo {figures(wall, **k, **net, echo=0.0)}")
        loose = {"hand.damping": 0.0}
        print(f"wall {K:6.0f} b = 0        {figures(wall, **k, **loose)}")
        print(f"mass {K:6.0f} b = 0        {figures(proxy, **k, **loose)}")
    print(f"mass  20000 port         {figures(proxy, tie__stiffness=20000.0)}")
    for lag in (0, 1, 2, 5, 10, 20):
        most = MASS / (2 * T**2 * (lag + 1) * (lag + 0.5))
        for part in (0.5, 2.0):
            at = {"tie.stiffness": part * most, "tie.lag": float(lag), "link.delay": float(lag)}
            print(f"lag {lag:2} at {part} K_max {part * most:8.0f} {figures(wall, **at)}")
    print(f"a sample of a port of three translations alone: {1e9 * alone():.0f} ns")
    instance = wall.parameters.instance({})
    instance.reset()
    times = np.arange(1, 5001) * T
    rows = np.empty((5000, wall.library.model.n_output))
    begin = time.process_time()
    instance.run(times, rows)
    spent = (time.process_time() - begin) / 5000
    print(f"a sample with its step of the device: {1e9 * spent:.0f} ns of processor time")


if __name__ == "__main__":
    main()
