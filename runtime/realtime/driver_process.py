"""Drivers in processes of their own: `runtime/c/host/host.c`, started and ended."""

from __future__ import annotations

import os
import subprocess
import tempfile
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from bgc.building.cache import open_cache
from bgc.building.servo import build_host
from bgc.diagnostics.catalogue.arguments import device_not_opened
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.realtime.servo_binding import OptionsStruct, RemoteState, ServoLibrary
from bgc.runtime.running.device_drivers import FoundDriver
from bgc.runtime.running.failures import quotable

WITHOUT_HARDWARE = ("trace", "pointer", "gamepad", "spring_hand")
"""Drivers of the runtime that drive no hardware; they run in the process of the loop."""

_OPENING_STATES = (RemoteState.STARTING, RemoteState.WITHOUT_POSE)
_AHEAD = 0.2e-3  # s before a sample, and at most that part of a period, at which a pose is read
_AHEAD_ALONE = 0.3e-3  # where the loop waits actively for the sample on the only core
_AHEAD_PART = 0.2
_OPENING = 120.0  # s in which a driver opens its device, which may be moved meanwhile
_FIRST_POSE = 2.0  # s from there to the first pose
_CLOSING = 0.2  # s in which it closes the device
_LOOK = 0.001  # s between two looks


class DriverProcess:
    """The process of one driver, and one in reserve that writes zero where the first one fails.

    `device` is its device, which is read `ahead` seconds before each sample.

    `library` is the shared object that holds the driver. The constructor returns once the device is
    open and has given a pose, or a fault.

    Raises BgError BG074 where it cannot be opened.
    """

    def __init__(
        self, servo: ServoLibrary, device: FoundDriver, library: str, options: OptionsStruct
    ) -> None:
        self._servo, self.device = servo, device
        self._processes: list[subprocess.Popen[bytes]] = []
        with tempfile.TemporaryFile() as shared:
            self.file = os.dup(shared.fileno())
        self._files = [self.file]
        longest = _AHEAD_ALONE if os.cpu_count() == 1 else _AHEAD
        self.ahead = min(longest, _AHEAD_PART * options.period)
        servo.share(self.file, options, self.ahead)
        named = "" if device.library is not None else device.driver
        common = (library, named, device.options)
        # The first process alone holds the end of `life`, and this one that of `watch`: the process
        # in reserve sees each of them end.
        program = build_host(open_cache())
        (life, held), (watch, kept) = os.pipe(), os.pipe()
        self._files += [life, watch, kept]
        try:
            try:
                self._start(program, ("-", "-", *common), (held,))
            finally:
                os.close(held)
            self._start(program, (str(life), str(watch), *common), (life, watch))
            self._wait_until_open()
        except BaseException:
            self.close(_LOOK)
            raise

    def _start(self, program: Path, arguments: Sequence[str], files: Sequence[int]) -> None:
        command = [str(program), str(self.file), *arguments]
        started = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            pass_fds=(self.file, *files),
            start_new_session=True,  # signals of a terminal are for this process
        )
        self._processes.append(started)

    def _wait_until_open(self) -> None:
        begun = opened = time.monotonic()
        while (found := self._servo.remote_state(self.file))[0] in _OPENING_STATES:
            now = time.monotonic()
            opened = opened if found[0] is RemoteState.WITHOUT_POSE else now
            if now - begun > _OPENING or now - opened > _FIRST_POSE:
                call = "open" if opened == now else "read"
                raise self._refusal(f"a call of `{call}` of its driver does not return")
            if self._processes[0].poll() is not None and self._processes[1].poll() is not None:
                raise self._refusal("the process of its driver has ended")
            time.sleep(_LOOK)
        if found[0] is RemoteState.REFUSED:
            raise self._refusal(found[1])

    def _refusal(self, reason: str) -> BgError:
        name, driver = self.device.name, self.device.driver
        return BgError([device_not_opened(name, driver, quotable(reason))])

    def __del__(self) -> None:
        self.close()

    def ask_to_close(self) -> None:
        """Ask the driver for zero force and to close the device."""
        if self._processes:
            self._servo.functions.bgc_remote_end(self.file)

    def close(self, patience: float = _CLOSING) -> None:
        """End both processes, at the latest after `patience` seconds each."""
        self.ask_to_close()
        while self._processes:  # the first one, whose end that in reserve answers
            process = self._processes.pop(0)
            with suppress(subprocess.TimeoutExpired):
                process.wait(patience)
            process.kill()
            process.wait()
        while self._files:
            os.close(self._files.pop())
