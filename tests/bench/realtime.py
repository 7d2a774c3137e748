"""The servo loop at 1 kHz: `python tests/bench/realtime.py [SECONDS [SCENE ..]]`, by default 600 s.

Rules: the paper's crane with the recorded hand, played again and again, and the hydraulic knuckle
boom on a vessel in a seaway, each with its own method and step. Keep the other cores busy
meanwhile, for a quiet machine proves nothing. Under SCHED_FIFO lateness p99 has to be below 0.2 ms
and less than 0.5 % of the deadlines may be missed; the mean work of a period has to be below 5 %
and 20 % of it. Each policy runs a tenth of that time without SCHED_FIFO, which a user needs rights
for (`bgc doc BG766`). Ten runs of the recording of the first minute have to give the bits of the
loop.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

import bgc
import bgc.library
from bgc.runtime.realtime.loop_options import RealtimeOptions
from bgc.runtime.realtime.servo_binding import POLICIES

_SCENES = Path(bgc.library.__path__[0]) / "scenes"
_HAND = _SCENES.parent / "traces/up_down_up.csv"
_CASES = (("two_beam_crane", {"hand": f"{_HAND}(loop=1)"}, 5.0), ("knuckle_boom_at_sea", {}, 20.0))
_REPLAYED, _REPLAYS = 60.0, 10


def measure(
    name: str,
    devices: dict[str, str],
    limit: float,
    seconds: float,
    *,
    policy: str | None = None,
    priority: bool = True,
) -> None:
    """Run a scene in a loop and print its figures."""
    model = bgc.compile(_SCENES / f"{name}.bg")
    options = RealtimeOptions(burst=0.0, watchdog=0.0, policy=policy, priority=priority)
    with model.realtime(seconds, devices=devices, options=options, keep=1) as loop:
        report = loop.wait()
    granted = "SCHED_FIFO" if report.fifo else "no SCHED_FIFO"
    print(f"{name}, {granted}, {report.samples:,} samples, policy {report.policy}")
    print(f"  lateness p99   {1e3 * report.lateness.p99:8.4f} ms    < 0.2")
    print(f"  missed         {100 * report.missed / report.samples:8.4f} %     < 0.5")
    print(f"  work, mean     {100 * report.work.mean / report.period:8.4f} %     < {limit:g}")
    print(f"  work, p50      {100 * report.work.p50 / report.period:8.4f} %")
    for line in report.lines():
        print(f"    {line}")


def replay() -> None:
    """Record a minute, and replay it ten times."""
    name, devices, _ = _CASES[0]
    model = bgc.compile(_SCENES / f"{name}.bg")
    with tempfile.TemporaryDirectory() as folder:
        record = Path(folder) / "motion.csv"
        options = RealtimeOptions(burst=0.0, watchdog=0.0)
        loop = model.realtime(_REPLAYED, devices=devices, options=options, record=record)
        with loop:
            loop.wait()
        every = loop.time[1] - loop.time[0]
        rows = np.ascontiguousarray(loop.rows)
        same = 0
        for _ in range(_REPLAYS):
            result = model.simulate(
                loop.time[-1], every=every, devices={"hand": str(record)}, error=False
            )
            found = np.column_stack([result[column] for column in loop.columns])
            same += found[-len(rows) :].tobytes() == rows[:, : len(loop.columns)].tobytes()
    print(f"replays of {len(rows):,} samples with the bits of the loop: {same} of {_REPLAYS}")


if __name__ == "__main__":
    wanted = float(sys.argv[1]) if len(sys.argv) > 1 else 600.0
    cases = [case for case in _CASES if not sys.argv[2:] or case[0] in sys.argv[2:]]
    for case in cases:
        measure(*case, wanted)
    for case in cases:
        for policy in POLICIES:
            measure(*case, wanted / 10, policy=policy, priority=False)
    if _CASES[0] in cases:
        replay()
