"""The report of a servo loop: how well it kept its periods, and why it ended."""

from __future__ import annotations

import errno
from collections.abc import Iterator, Sequence

from bgc.diagnostics.catalogue import realtime as messages
from bgc.diagnostics.catalogue.run import device_failed
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.record_class import dataclass
from bgc.runtime.realtime.servo_binding import (
    POLICIES,
    End,
    OptionsStruct,
    ReportStruct,
    TimesStruct,
)
from bgc.runtime.running.failures import quotable
from bgc.runtime.running.quantity import spelled_time

_GOOD_ENDS = (End.RUNNING, End.DONE, End.STOPPED)


@dataclass(frozen=True, slots=True)
class Times:
    """Quantiles of a time in s: of all samples, p99 took no longer in 99 of 100."""

    mean: float
    p50: float
    p99: float
    p999: float
    worst: float

    def __str__(self) -> str:
        parts = (("p50", self.p50), ("p99", self.p99), ("p99.9", self.p999), ("worst", self.worst))
        return ", ".join(f"{name} {_rounded(value)}" for name, value in parts)


@dataclass(frozen=True, slots=True)
class Report:
    """The state of a loop.

    Attributes
    ----------
    end
        `RUNNING`, or why it ended: `DONE`, `STOPPED`, or a fault.
    samples, missed, overruns
        Samples taken, those whose work ended after the deadline, and those that were late by a
        period or more.
    dropped, skipped, behind
        By the overrun policy: periods left out (hold), samples without the devices (skip), and
        the seconds by which simulated time has fallen behind the clock (hold and slow).
    time, elapsed
        Simulated time, and time of the clock, s.
    lateness, jitter, work
        Begin of a sample after its instant; difference of an interval from the period; computing
        time of a period.
    gain
        Part of the force that is let through, 0 to 1: the ramp.
    limited, saturated, no_news
        Samples in which a limit acted, a motor was saturated, a device gave nothing new.
    refused
        Poses that were not finite, or that no hand can have; each ends the loop.
    worst_power
        Largest power into the hand, W.
    fastest
        Fastest motion of a device with motors, m/s.
    given
        Energy that the hands have received since the start, J; below 0 what they have given.
    created, taken, owed
        Energy that ramp and limits of the loop have created, since the force was not that of the
        model; what of it was taken back; and what a hand has received of it since the force last
        rose from zero, and not yet given back, J.
    zero_after
        Time from the instant of the failed sample to zero force, s; None without an end, and where
        a device is `unsettled`: its driver did not confirm zero force.
    fifo, locked
        Whether SCHED_FIFO and locked memory were granted; None where they were not asked for.
    lost_records
        Records that found no room, since nobody took them.
    exchanges
        Models that took the place of another one.
    lag
        Largest lag that a device has measured, in samples, from a position to the force that
        answers it; None where no device measures it.
    late_poses, late_device
        Samples in which it was above the lag that the device states, and that device.
    problem
        The fault that ended the loop, None if there is none.
    """

    end: End
    samples: int
    missed: int
    overruns: int
    dropped: int
    skipped: int
    behind: float
    time: float
    elapsed: float
    lateness: Times
    jitter: Times
    work: Times
    gain: float
    released: bool
    limited: int
    saturated: int
    no_news: int
    refused: int
    worst_power: float
    fastest: float
    given: float
    created: float
    taken: float
    owed: float
    zero_after: float | None
    unsettled: bool
    fifo: bool | None
    locked: bool | None
    lost_records: int
    exchanges: int
    lag: float | None
    late_poses: int
    late_device: str
    policy: str
    period: float
    problem: Diagnostic | None = None

    @property
    def is_running(self) -> bool:
        """True while the loop runs."""
        return self.end is End.RUNNING

    @property
    def failed(self) -> bool:
        """True if a fault ended the loop."""
        return self.end not in _GOOD_ENDS

    def lines(self) -> Iterator[str]:
        """The report as lines of text."""
        slow = f", {self.behind:.4g} s behind the clock" if self.behind > 0 else ""
        models = f", {self.exchanges + 1} models" if self.exchanges else ""
        period = spelled_time(self.period)
        yield f"{self.samples:,} samples of {period}, {self.time:.6g} s{slow}{models}"
        share = 100.0 * self.missed / max(self.samples, 1)
        yield f"deadlines missed: {self.missed:,} ({share:.3g} %), policy {self.policy}" + (
            self._late()
        )
        yield f"lateness  {self.lateness}"
        yield f"jitter    {self.jitter}"
        yield f"work      {self.work}"
        granted = {None: "not asked for", True: "granted", False: "refused"}
        yield f"real-time priority {granted[self.fifo]}, locked memory {granted[self.locked]}"
        if self.limited or self.saturated:
            yield f"force limited in {self.limited:,} samples, saturated in {self.saturated:,}"
        if self.given or self.created:
            yield (
                f"energy: {1e3 * self.given:.4g} mJ into the hand; ramp and limits created "
                f"{1e3 * self.created:.4g} mJ, {1e3 * self.taken:.4g} mJ taken back, "
                f"{1e3 * self.owed:.4g} mJ owed"
            )
        if self.fastest or self.refused:
            yield (
                f"fastest motion {self.fastest:.3g} m/s, samples without a new pose: "
                f"{self.no_news:,}, poses refused: {self.refused}"
            )
        if self.lag is not None:
            yield f"largest lag measured: {self.lag:.3g} samples"

    def _late(self) -> str:
        texts = {"hold": f"{self.dropped:,} periods left out", "slow": f"{self.behind:.4g} s added"}
        return f": {texts.get(self.policy, f'{self.skipped:,} samples without the devices')}"

    def warnings(self) -> Iterator[Diagnostic]:
        """Warn of refused priority and missed deadlines."""
        asked = {"SCHED_FIFO": self.fifo, "locked memory": self.locked}
        if refused := [name for name, given in asked.items() if given is False]:
            yield messages.not_realtime(refused)
        if self.missed and self.samples:
            has_priority = self.fifo is True
            yield messages.deadlines_missed(
                self.missed, self.samples, self.policy, self._late(), has_priority
            )
        if self.late_poses and self.lag is not None:
            yield messages.lag_exceeded(self.late_device, self.lag, self.late_poses, self.samples)
        if self.unsettled:
            yield messages.zero_not_confirmed()
        if self.lost_records:
            yield messages.records_lost(self.lost_records)


def _rounded(seconds: float) -> str:
    return spelled_time(float(f"{seconds:.3g}")) if seconds > 0 else "0 s"


def report_of(
    raw: ReportStruct,
    options: OptionsStruct,
    devices: Sequence[str],
    model_failure: Diagnostic | None,
) -> Report:
    """Read the report of C; `model_failure` explains the model's status."""
    end = End(raw.end)
    return Report(
        end=end,
        samples=raw.samples,
        missed=raw.missed,
        overruns=raw.overruns,
        dropped=raw.dropped,
        skipped=raw.skipped,
        behind=raw.behind,
        time=raw.time,
        elapsed=raw.elapsed,
        lateness=_times(raw.lateness),
        jitter=_times(raw.jitter),
        work=_times(raw.work),
        gain=raw.gain,
        released=bool(raw.released),
        limited=raw.limited,
        saturated=raw.saturated,
        no_news=raw.no_news,
        refused=raw.refused,
        worst_power=raw.worst_power,
        fastest=raw.fastest,
        given=raw.given,
        created=raw.created,
        taken=raw.taken,
        owed=raw.owed,
        unsettled=bool(raw.unsettled),
        zero_after=None if raw.zero_after < 0 else raw.zero_after,
        fifo=_granted(raw.fifo),
        locked=_granted(raw.locked),
        lost_records=raw.lost_records,
        exchanges=raw.exchanges,
        lag=None if raw.lag < 0 else raw.lag,
        late_poses=raw.late_poses,
        late_device=devices[raw.late_device] if raw.late_device >= 0 else "",
        policy=POLICIES[options.policy],
        period=options.period,
        problem=_problem(end, raw, options, devices, model_failure),
    )


def _times(raw: TimesStruct) -> Times:
    return Times(raw.mean, raw.p50, raw.p99, raw.p999, raw.worst)


def _granted(answer: int) -> bool | None:
    return None if answer == 0 else answer > 0


def _problem(
    end: End,
    raw: ReportStruct,
    options: OptionsStruct,
    devices: Sequence[str],
    model_failure: Diagnostic | None,
) -> Diagnostic | None:
    device = devices[raw.device] if 0 <= raw.device < len(devices) else ""
    reason = quotable(raw.message.decode("utf-8", "backslashreplace"))
    match end:
        case End.MODEL:
            return model_failure
        case End.LOST:
            return device_failed(raw.time, [device], reason)
        case End.BAD_POSE:
            return messages.bad_pose(raw.time, device)
        case End.JUMP:
            return messages.implausible_pose(raw.time, device, reason)
        case End.STUCK:
            return messages.device_stuck(raw.time, device, options.stale, reason)
        case End.LATE:
            return messages.too_late(raw.time, raw.missed, raw.samples)
        case End.STALLED:
            return messages.loop_stalled(raw.time, options.watchdog, bool(raw.in_driver))
        case End.NO_THREAD:
            return messages.cannot_start(errno.errorcode[errno.EAGAIN])
        case _:
            return None
