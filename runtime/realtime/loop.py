"""A model in step with the clock: the servo loop as a Python user holds it."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from threading import Event, Lock, Thread
from types import TracebackType
from typing import Literal, Self, Unpack

import numpy as np

from bgc.diagnostics.catalogue.arguments import device_not_opened
from bgc.diagnostics.catalogue.exchange import cannot_exchange
from bgc.diagnostics.catalogue.realtime import (
    python_device_failed,
    recording_ended,
    thread_left,
)
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.public import public_function
from bgc.language.solver import Solver, SolverKeywords
from bgc.record_class import replace
from bgc.runtime.realtime.course import (
    Course,
    make_course,
    options_of,
    places_of,
    resting_poses,
)
from bgc.runtime.realtime.driver_process import WITHOUT_HARDWARE, DriverProcess
from bgc.runtime.realtime.loop_options import RealtimeOptions
from bgc.runtime.realtime.loop_records import (
    POSE_STAMP,
    Kept,
    Recorder,
    forces_of,
    rows_of,
    whole_poses_of,
)
from bgc.runtime.realtime.loop_report import Report, report_of
from bgc.runtime.realtime.passivity import Coupling, couplings, lag_warnings
from bgc.runtime.realtime.pointers import Pointers
from bgc.runtime.realtime.python_device import PythonDevice, PythonThread, now
from bgc.runtime.realtime.servo_binding import ClockStruct, End, Servo, load_servo
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.rest_report import AtRest
from bgc.runtime.results.result import Result
from bgc.runtime.running.arguments import read_solver, with_solver_keywords
from bgc.runtime.running.device_drivers import DeviceChoice, find_drivers, read_choices
from bgc.runtime.running.failures import quotable
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameters import ParameterValue
from bgc.runtime.running.poses import pose_words
from bgc.runtime.running.simulate import method_of, named_result
from bgc.runtime.running.structures import Status

_DRAIN_SECONDS = 0.01
_PATIENCE = 2.0  # s without a sample until a loop that does not end is left behind
_TIMES: tuple[Literal["lateness", "jitter", "work"], ...] = ("lateness", "jitter", "work")
_Device = str | PythonDevice


class Realtime:
    """A running loop; also a context manager, which starts it and stops it.

    The loop itself is a thread of C at a fixed rate: it reads the devices, writes the limited
    force, and integrates to the next sample. Python takes its records every 10 ms: `step()`,
    `on_records`, `record` and the arrays here stand outside the loop, which never waits for them.

    Attributes
    ----------
    devices
        Names of the devices.
    at_rest
        The start of the present model, where it is one at rest.
    warnings
        Of the recording and of devices that are Python objects.
    """

    def __init__(
        self,
        model: LoadedModel,
        method: Solver,
        options: RealtimeOptions,
        *,
        duration: float | None = None,
        devices: Mapping[str, _Device] | None = None,
        record: Path | None = None,
        keep: int = 60_000,
        parameters: Mapping[str, ParameterValue] | None = None,
        on_records: Callable[[Array], None] | None = None,
        clock: ClockStruct | None = None,
    ) -> None:
        self.warnings: list[Diagnostic] = []
        self._on_records = on_records
        self._given = options.checked()
        if clock is not None:  # on which no other process runs
            self._given = replace(self._given, supervise=False)
        self._parameters = parameters or {}
        self._final: Report | None = None
        self._own = {k: v for k, v in (devices or {}).items() if not isinstance(v, str)}
        named = {k: v for k, v in (devices or {}).items() if isinstance(v, str)}
        self._choices = read_choices(named) | dict.fromkeys(self._own, DeviceChoice("pointer"))
        course = make_course(model, method, parameters or {})
        # In the order of their posts; the reader of records may be behind the loop.
        self._courses, self._read = [course], 0
        self._found = find_drivers(course.instance, model.folder, self._choices)
        self.devices = tuple(device.name for device in self._found)
        self._exchanging, self._feeding = Lock(), Lock()
        library = load_servo()
        self._defaults = library.defaults
        self._library, self._processes = library, list[DriverProcess]()
        self._options = options_of(course, library.defaults(), self._given, duration)
        self._servo = Servo(library, course.instance, self._options, model.row_width, clock)
        self._pointers = Pointers(self._servo, self._found, course.instance)
        try:
            self._open_devices()
            if course.rests:
                self._servo.seed(resting_poses(len(self.devices)))
            self.at_rest: AtRest | None = course.start()
        except BaseException:
            self._servo.free()
            self._end_processes()
            raise
        self._record = record
        self._recorder = None if record is None else Recorder(record, self.devices)
        self._kept = Kept(keep, self._servo.record_size)
        self._news, self._ended = Event(), Event()
        self._drain: Thread | None = None
        self._threads: list[PythonThread] = []

    def _open_devices(self) -> None:
        for index, device in enumerate(self._found):
            address, options = device.address, os.fsencode(device.options)
            if self._given.supervise and device.driver not in WITHOUT_HARDWARE:
                library = device.library or self._courses[0].instance.library.functions
                process = DriverProcess(self._library, device, library._name, self._options)
                self._processes.append(process)
                address, options = self._library.remote, b"fd=%d" % process.file
            status, message = self._servo.open(index, address, options)
            if status is not Status.OK:
                reason = quotable(message)
                raise BgError([device_not_opened(device.name, device.driver, reason)])
        self._take_back(self._courses[0])
        for name, own in self._own.items():
            self.pointer(**own.read(), device=name)

    def _take_back(self, course: Course, address: int | None = None) -> None:
        for name in course.coupled:
            self._servo.take_back(self.devices.index(name), address)

    # --- the course of a loop ------------------------------------------------------------------

    def couplings(self) -> list[Coupling]:
        """The forces on the devices as functions of their positions, before the loop starts.

        They state the damping that a passive loop needs; warnings go to `warnings`.
        """
        can = {name: self._servo.capabilities(k) for k, name in enumerate(self.devices)}
        course = self._courses[0]
        ahead = {process.device.name: process.ahead for process in self._processes}
        found = couplings(course.model, course.instance, can, self._parameters, ahead)
        self.warnings += lag_warnings(course.model, course.instance, can)
        self.warnings += (warning for one in found for warning in one.warnings())
        return found

    def start(self) -> Self:
        """Start the threads of loop and watchdog, and take records from now on."""
        self._servo.start()
        self._drain = Thread(target=self._take_until_end, daemon=True)
        self._drain.start()
        self._threads = [
            PythonThread(
                own,
                partial(self.pointer, device=name),
                partial(self._written, name),
                partial(self._fail_device, name),
            )
            for name, own in self._own.items()
        ]
        return self

    def run_here(self) -> Report:
        """Run the loop in this thread to its end, without threads, on a clock of one's own."""
        self._servo.loop()
        self._take()
        return self.close()

    def step(self, timeout: float = 1.0) -> Report:
        """Wait for the next records, or the end, at most `timeout` seconds; return the report."""
        self._news.clear()
        if not self._ended.is_set():
            self._news.wait(timeout)
        return self.report

    def wait(self) -> Report:
        """Wait for the end of the loop; Ctrl-C stops it. Returns the final report."""
        try:
            while self.report.is_running:
                self.step(0.1)
        except KeyboardInterrupt:
            self.stop()
            raise
        return self.close()

    def stop(self, *, at_once: bool = False, within: float | None = None) -> Report:
        """End the loop when the force has fallen to zero; return the final report.

        The force falls in the time of the ramp, while the model runs on; with `at_once` it is zero
        after the present sample, and with `within` after so many seconds, whatever the ramp.
        """
        if self._final is None:
            self._servo.stop(at_once)
            if within is not None and not self._servo.join(within):
                self._servo.stop(at_once=True)
        return self.close()

    def close(self) -> Report:
        """Wait for the threads, close devices and recording; return the final report.

        Raises BgError BG775 where the loop does not end.
        """
        if self._final is not None:
            return self._final
        self._join()
        self._ended.set()
        for thread in self._threads:
            thread.stop()
        if self._drain is not None:
            self._drain.join()
        self._close_recorder()
        self._histograms = {name: self.histogram(name) for name in _TIMES}
        with self._exchanging, self._feeding:  # other threads may still hand over something
            self._final = self._read_report()
            self._servo.free()
            self._end_processes()
        return self._final

    def _end_processes(self) -> None:
        for process in self._processes:
            process.ask_to_close()
        while self._processes:
            self._processes.pop().close()

    def _join(self) -> None:
        """Wait for the threads as long as the loop takes samples; BG775 where it does not end."""
        samples = -1
        while not self._servo.join(_PATIENCE):
            before, samples = samples, self._servo.report().samples
            if samples == before:
                raise BgError([thread_left(_PATIENCE)])

    def _close_recorder(self) -> None:
        if self._recorder is not None:
            self._recorder.close()
            if self._recorder.problem is not None:
                self.warnings.append(recording_ended(*self._recorder.problem))

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()

    @property
    def report(self) -> Report:
        """The present report of the loop; final once it has been stopped or waited for."""
        return self._final or self._read_report()

    def histogram(self, name: Literal["lateness", "jitter", "work"]) -> Array:
        """Classes of a time of the loop: upper ends, s, and samples in each, (n, 2).

        Classes grow by 1/32 of an octave; empty ones are left out.
        """
        if self._final is not None:
            return self._histograms[name]
        return self._servo.histogram(_TIMES.index(name))

    def _read_report(self) -> Report:
        raw = self._servo.report()
        failure = None
        if raw.end == End.MODEL:
            course = self._courses[raw.exchanges]
            failure = course.model.explain(course.instance, Status(raw.status))
        return report_of(raw, self._options, self.devices, failure)

    # --- another model -------------------------------------------------------------------------

    @public_function
    @with_solver_keywords
    def exchange(
        self,
        model: LoadedModel,
        *,
        parameters: Mapping[str, ParameterValue] | None = None,
        wait: bool = True,
        **run: Unpack[SolverKeywords],
    ) -> None:
        """Let another model, or this one with other parameters, take the place of the present one.

        The devices stay open and the loop keeps its pace. The force falls to zero in the time of
        the ramp, the new model starts, at rest where its scene says so, at its own time, and the
        force rises again. From then on `time`, `rows`, `columns` and `result` are those of the new
        model, and a recording goes on in another table (`motion_2.csv`), which replays with the
        new scene. The start is computed before anything changes, in the calling thread.

        Parameters
        ----------
        model
            A model whose scene has devices of the same names and the same period.
        parameters, **run
            As for `Model.realtime`.
        wait
            Whether to return only when the new model runs, or the loop has ended.

        Raises
        ------
        BgError
            BG757: the devices or the period differ, another exchange is under way, or the loop has
            ended; or an argument, a parameter or the start is at fault. The loop goes on.
        """
        method, notices = method_of(model, read_solver(run))
        course = make_course(model, method, parameters or {})
        with self._exchanging:
            self._post(course)
            place = len(self._courses) - 1
        self.warnings += notices
        while wait and self._drain is not None and self._read < place and not self._ended.is_set():
            self._ended.wait(_DRAIN_SECONDS)

    def _post(self, course: Course) -> None:
        """Start a course at rest or at the present pose, and hand it to the loop."""
        places = places_of(course, self.devices, self._options.period)
        if self._final is not None:
            raise BgError([cannot_exchange("the loop has ended")])
        options = options_of(course, self._defaults(), self._given, None)
        poses = resting_poses(len(self.devices)) if course.rests else self._present_poses()
        width = course.model.row_width
        address = self._servo.prepare(course.instance, options, width, places, poses)
        self._take_back(course, address)
        self._courses.append(course)
        try:
            at_rest = course.start()
            if not self._servo.post(address, course.instance):
                running = self.report.is_running
                reason = "another exchange is under way" if running else "the loop has ended"
                raise BgError([cannot_exchange(reason)])
        except BaseException:
            self._courses.pop()
            self._servo.drop(address)
            raise
        self.at_rest = at_rest

    def _present_poses(self) -> Array:
        if self._drain is None:
            self._take()  # from within the loop's own thread
        latest = self._kept.latest
        if latest is None or not self.devices:
            return resting_poses(len(self.devices))
        return np.vstack([whole_poses_of(latest, k) for k in range(len(self.devices))])

    def _follow_exchange(self) -> None:
        """Go on to the records of the next course."""
        self._servo.next()
        self._kept.forget(self._servo.record_size)
        self._read += 1
        if self._record is not None:
            self._close_recorder()
            path = self._record.with_stem(f"{self._record.stem}_{self._read + 1}")
            self._recorder = Recorder(path, self.devices)

    @property
    def course(self) -> Course:
        """The course of the records."""
        return self._courses[self._read]

    # --- records -------------------------------------------------------------------------------

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the model's outputs, in the scene's order."""
        return self.course.columns

    @property
    def time(self) -> Array:
        """Times of the samples that are kept, s."""
        return self._records[:, 0]

    @property
    def rows(self) -> Array:
        """Outputs of the samples that are kept, (n, outputs), as `columns` names them."""
        return self.course.outputs(rows_of(self._records, len(self.devices)))

    def forces(self, device: str | None = None) -> Array:
        """Force, torque and gripper force that were written to a device, (n, 7)."""
        return forces_of(self._records, self.devices.index(device or self.devices[0]))

    def result(self, every: float | None = None) -> Result:
        """The samples that are kept as the result of a run, in rows about `every` seconds apart."""
        records = self._records
        times, rows = records[:, 0], rows_of(records, len(self.devices))
        if every is not None and len(times):
            stride = max(1, round(every / self._options.period))
            chosen = np.unique([*range(0, len(times), stride), len(times) - 1])
            times, rows = times[chosen], rows[chosen]
        notices = (*self.warnings, *self.report.warnings())
        own = self.course
        result = named_result(own.model, times, rows, own.method, own.instance, notices)
        problem = self.report.problem
        return result if problem is None else result.ended("failed", problem.message)

    def latest(self) -> dict[str, float]:
        """The outputs of the last sample by name; empty before the first."""
        latest = self._kept.latest
        if latest is None:
            return {}
        row = self.course.outputs(rows_of(latest, len(self.devices)))[-1]
        return dict(zip(self.columns, row.tolist(), strict=True))

    def last_force(self, index: int) -> list[float]:
        """The values written to device `index` in the last sample, 7 numbers; zero before it."""
        latest = self._kept.latest
        return [0.0] * 7 if latest is None else forces_of(latest, index)[-1].tolist()

    def pause(self, seconds: float) -> None:
        """Wait for `seconds`, or for the end of the loop."""
        self._ended.wait(seconds)

    @property
    def _records(self) -> Array:
        return self._kept.all()

    def _take_until_end(self) -> None:
        while not self._ended.is_set():
            self._take()
            if self._servo.report().end != End.RUNNING:
                break
            for thread in self._threads:
                thread.watch(self._given.stale)
            self._ended.wait(_DRAIN_SECONDS)
        self._take()
        self._ended.set()
        self._news.set()

    def _take(self) -> None:
        """Take all records that are ready, and hand them on."""
        while True:
            is_retired = self._servo.is_retired  # before its last records are taken
            records = self._servo.take()
            if len(records) == 0:
                if not is_retired:
                    return
                self._follow_exchange()
                continue
            self._kept.add(records)
            if self._recorder is not None:
                self._recorder.write(records)
            if self._on_records is not None:
                self._on_records(records)
            self._news.set()

    # --- poses from Python -----------------------------------------------------------------------

    def pointer(
        self,
        position: Sequence[float] | Array = (0.0, 0.0, 0.0),
        orientation: Sequence[float] | Array = (1.0, 0.0, 0.0, 0.0),
        *,
        velocity: Sequence[float] | Array | None = None,
        angular_velocity: Sequence[float] | Array | None = None,
        gripper: float = 0.0,
        buttons: Sequence[float] = (),
        stamp: float | None = None,
        age: float = 0.0,
        device: str | None = None,
    ) -> None:
        """Hand a pose to a device with the driver `pointer` or `gamepad`.

        The loop does not wait for it, and takes the pose in its next sample.

        Parameters
        ----------
        position, orientation
            m, and a unit quaternion, scalar first.
        velocity, angular_velocity
            m/s and rad/s; a velocity that is not given is computed from the positions.
        gripper, buttons
            m, and 0 or 1 for up to eight buttons.
        stamp
            When it was measured, s, by any clock that goes on; by default the present.
        age
            s, from the pose that the force held now answers to this one; 0: not known.
        device
            Its name, where several devices are pointers.

        Raises
        ------
        BgError
            BG777: no device is a pointer, or several are.
        """
        index, rates = self._pointers.index(device), (velocity, angular_velocity)
        measured = now() if stamp is None else stamp
        words = pose_words(position, orientation, rates, gripper, buttons, measured, age)
        with self._feeding:
            if self._final is None:
                self._pointers.feed(index, words)

    def _written(self, name: str) -> tuple[Array, float] | None:
        latest, index = self._kept.latest, self.devices.index(name)
        if latest is None:
            return None
        return forces_of(latest, index)[-1], float(whole_poses_of(latest, index)[-1, POSE_STAMP])

    def _fail_device(self, name: str, reason: str) -> None:
        self.warnings.append(python_device_failed(name, quotable(reason)))
        self._servo.stop(at_once=True)
