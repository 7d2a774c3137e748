"""A held handle for tests of the servo loop, with its model and a device that injects faults."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from bgc.building.build import runtime_directory
from bgc.runtime.realtime.loop import Realtime
from bgc.runtime.realtime.loop_options import RealtimeOptions
from bgc.runtime.realtime.servo_binding import ClockStruct, NowFunction, SleepFunction
from bgc.runtime.running.simulate import method_of

STIFFNESS, DAMPING = 50.0, 3.0
SCENE = f"""/// A handle held by a spring; its motion drives a pendulum.
model Held {{
  input x[3] : m;
  input v[3] : m/s;
  input q[4];
  param limit = 10;
  param first = 0.3;
  param gravity = 20 in 0 .. 100;
  param push = 0;
  state angle = first;
  state rate = 0;
  der(angle) = rate;
  der(rate) = push - gravity*sin(angle) + 3*x[1] + v[1] + q[4];
  assert angle < limit, "the pendulum is too high";
}}
scene s of Held {{
  device hand = trace(file = "still.csv");
  drive x = hand.position;
  drive v = hand.velocity;
  drive q = hand.orientation;
  drive hand.force = [
    -{STIFFNESS} N/m*hand.position[1] - {DAMPING} N*s/m*hand.velocity[1], 1 N, 0 N];
  observe angle, rate, x[1] as x;
  deadline 1 ms, skip;
  step 1 ms;
  run 1 s every 1 ms;
}}
model Heavier is Held {{
  output lift = 2*angle;
}}
scene heavier of Heavier {{
  device hand = trace(file = "absent.csv");
  drive x = hand.position;
  drive v = hand.velocity;
  drive q = hand.orientation;
  drive hand.force = [0 N, 2 N, 0 N];
  observe angle, lift;
  set first = 0.1;
  step 1 ms;
  run 1 s every 1 ms;
}}
scene other_device of Held {{
  device stick = pointer();
  drive x = stick.position;
  drive v = stick.velocity;
  drive q = stick.orientation;
  observe angle;
  step 1 ms;
  run 1 s;
}}
"""


def prepare(folder: Path) -> Path:
    """Fill a folder with the model `held.bg` and the device `faulty.so`; return it."""
    (folder / "still.csv").write_text("time,x,y,z\n0,0.02,0,0\n")
    (folder / "held.bg").write_text(SCENE)
    build_driver("faulty", folder)
    return folder


def build_driver(name: str, folder: Path) -> Path:
    """Compile a driver of `devices` into a folder."""
    source = Path(__file__).parent / f"devices/{name}.c"
    flags = ["-std=c11", "-O1", "-Wall", "-Wextra", "-Werror", "-D_POSIX_C_SOURCE=200809L"]
    include = f"-I{runtime_directory()}"
    made = folder / f"{name}.so"
    subprocess.run(
        ["cc", *flags, include, "-shared", "-fPIC", "-o", str(made), str(source), "-lm"], check=True
    )
    return made


class Bench:
    """A loop with the faulty device on the virtual clock."""

    def __init__(self, model: Any, folder: Path, name: str = "hand") -> None:
        self.model, self.device, self.name = model, str(folder / "faulty.so"), name
        self.library = ctypes.CDLL(self.device)
        self.clock = ClockStruct(
            ctypes.cast(self.library.virtual_now, NowFunction),
            ctypes.cast(self.library.virtual_sleep, SleepFunction),
            None,
        )
        self.loop: Realtime

    def make(self, fault: str = "", duration: float = 1.0, **options: Any) -> Realtime:
        parameters = options.pop("parameters", None)
        record = options.pop("record", None)
        keep = options.pop("keep", 60_000)
        since = options.pop("since", 0)  # ns, on the clock
        chosen = replace(RealtimeOptions(priority=False, ramp=0.0), **options)
        ctypes.c_void_p.in_dll(self.library, "virtual_watch").value = None
        ctypes.c_void_p.in_dll(self.library, "virtual_call").value = None
        ctypes.c_int64.in_dll(self.library, "virtual_time").value = since
        self.loop = Realtime(
            self.model,
            method_of(self.model)[0],
            chosen,
            duration=duration,
            devices={self.name: f"{self.device}({fault})"},
            parameters=parameters,
            record=record,
            keep=keep,
            clock=self.clock,
        )
        return self.loop

    def watched(self) -> None:
        """The watchdog acts whenever a fault lets time pass."""
        servo = self.loop._servo
        watch = ctypes.cast(servo._functions.bgc_servo_watch, ctypes.c_void_p)
        ctypes.c_void_p.in_dll(self.library, "virtual_watch").value = watch.value
        ctypes.c_void_p.in_dll(self.library, "virtual_servo").value = servo._servo

    def at(self, time: float, call: Callable[[], object]) -> None:
        """Call a function from within the loop, in the sample at a simulated time."""
        self._call = ctypes.CFUNCTYPE(None)(call)
        address = ctypes.cast(self._call, ctypes.c_void_p).value
        ctypes.c_double.in_dll(self.library, "virtual_call_at").value = time
        ctypes.c_void_p.in_dll(self.library, "virtual_call").value = address

    @property
    def force(self) -> list[float]:
        return list((ctypes.c_double * 3).in_dll(self.library, "faulty_force"))
