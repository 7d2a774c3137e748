"""A program in the real-time loop, on a clock of its own, against the same run offline."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from program_text import write
from program_tree import Program

import bgc
from bgc.runtime.realtime.loop import Realtime
from bgc.runtime.realtime.loop_options import RealtimeOptions
from bgc.runtime.realtime.servo_binding import ClockStruct, NowFunction, SleepFunction
from bgc.runtime.running.simulate import method_of

PERIOD, SAMPLES = 0.002, 200  # s, and periods of a run
LOOK = 1000  # ns by which the clock moves when the loop looks at it


def loop_differences(program: Program, place: Path) -> list[str]:
    """The columns whose bits differ between the loop and a plain run, both with one trace.

    The hand multiplies the first driven input of the scene, where there is one. A run that ends
    with a status has to end with it in both; else the list holds both codes.
    """
    times = np.arange(0.0, 1.0, 0.02)
    motion = place / "motion.csv"
    motion.write_text("time,x,y,z\n" + "".join(f"{t},{0.3 * np.sin(9 * t)},0,0\n" for t in times))
    path = place / "program.bg"
    path.write_text(held_by_a_hand(write(program)), encoding="utf-8")
    model = bgc.compile(path, preview=True)
    clock = VirtualClock()
    loop = Realtime(
        model,
        method_of(model)[0],
        RealtimeOptions(priority=False),
        duration=SAMPLES * PERIOD,
        devices={"hand": str(motion)},
        clock=clock.struct,
    )
    report = loop.run_here()
    ended = report.problem.code if report.problem is not None else ""
    try:
        run = model.simulate(SAMPLES * PERIOD, devices={"hand": str(motion)}, error=False)
    except bgc.BgError as err:
        code = err.diagnostics[0].code
        return [] if code == ended else [f"{ended or 'no end'} in the loop, {code} offline"]
    if ended or len(loop.rows) != SAMPLES + 1:
        return [f"{ended or len(loop.rows)} in the loop alone"]
    rows = loop.rows.T
    return [
        name
        for name, row in zip(loop.columns, rows, strict=True)
        if np.asarray(run[name]).tobytes() != row.tobytes()
    ]


def held_by_a_hand(text: str) -> str:
    """The text of a program with a device in its scene, and with fixed steps."""
    head, scene = text.rsplit("scene ", 1)
    scene = scene.replace("\n", '\n  device hand = trace(file = "motion.csv");\n', 1)
    moved = r"drive \1 = (\2) * (1 + hand.position[1] / 1 m);"
    scene = re.sub(r"drive (\w+) = (.*);", moved, scene, count=1)
    step = f"{PERIOD} s"
    scene = re.sub(r"run .*;", f"step {step};\n  run {SAMPLES * PERIOD} s every {step};", scene)
    return f"{head}scene {scene}"


class VirtualClock:
    """A clock that only the loop moves: by its looks and by its sleep, in ns."""

    def __init__(self) -> None:
        self.time = 0
        # The structure holds addresses: the functions have to live as long as it does.
        self._functions = NowFunction(self._now), SleepFunction(self._sleep)
        self.struct = ClockStruct(*self._functions, None)

    def _now(self, _: object) -> int:
        self.time += LOOK
        return self.time

    def _sleep(self, _: object, until: int) -> None:
        self.time = max(self.time, until)
