"""A driver in a process of its own beside one in that of the loop: `driver_process.py [SECONDS]`.

The crane of the paper at 1 kHz with the stand-in of `tests/unit/devices/standin.c`, whose read and
write take no time, so that all that is measured is the way between two processes. Both runs take
turns, since a machine with other work is not the same a minute later. Then each fault: the time
from its instant to zero force at the hardware.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

import bgc
import bgc.library

sys.path.insert(0, str(Path(__file__).parents[1] / "unit"))

from held import build_driver
from test_driver_process import FAULTS, NAMES

from bgc.runtime.realtime.loop_options import RealtimeOptions

_SCENE = Path(bgc.library.__path__[0]) / "scenes" / "two_beam_crane.bg"
_TURNS = 6


def main(seconds: float) -> None:
    """Print the figures of both, and of each fault."""
    model = bgc.compile(_SCENE)
    with tempfile.TemporaryDirectory() as place:
        driver, unit = build_driver("standin", Path(place)), Path(place) / "unit"
        for turn in range(2 * _TURNS):
            options = RealtimeOptions(burst=0.0, supervise=turn % 2 == 1)
            device = {"hand": f"{driver}(file={unit})"}
            with model.realtime(seconds, devices=device, options=options, keep=1) as loop:
                report = loop.wait()
            name = "its own process" if turn % 2 else "the process of the loop"
            news = 100.0 * report.no_news / report.samples
            print(f"{name:24} work {report.work}; lateness p99 {1e6 * report.lateness.p99:.1f} us")
            print(f"{'':24} without a new pose: {news:.2g} %")
        for fault, code, *_ in FAULTS:
            unit.unlink(missing_ok=True)
            device = {"hand": f"{driver}(file={unit}, fault={fault}, from=1)"}
            options = RealtimeOptions(burst=0.0, ramp=0.1)
            with model.realtime(5.0, devices=device, options=options, keep=1) as loop:
                loop.wait()
            found = dict(zip(NAMES, np.fromfile(unit), strict=True))
            after = 1e3 * (found["zero_at"] - found["fault_at"])
            print(
                f"{fault:24} {code}, zero force after {after:.3g} ms, at most {found['most']:.3g} N"
            )


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 20.0)
