"""BG762-BG769 and BG775-BG783: the servo loop and its devices."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, warning
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


def bad_pose(time: float, device: str) -> Diagnostic:
    """BG762: a device gave a value that is not finite"""
    return error(
        "BG762",
        f"device `{device}` gave a value that is not finite at t = {time:.9g} s; its force is zero",
        help="check the device with its maker's tools, then its driver",
    )


def device_stuck(time: float, device: str, stale: float) -> Diagnostic:
    """BG763: a device gives no new data"""
    return error(
        "BG763",
        f"device `{device}` gave nothing new for {stale:.3g} s (t = {time:.9g} s); "
        "its force is zero",
        help='check the device and what sends its data; `--stale "0.5 s"` allows more time',
    )


def too_late(time: float, missed: int, samples: int) -> Diagnostic:
    """BG764: too many deadlines in a row were missed"""
    return error(
        "BG764",
        f"{missed:,} of {samples:,} deadlines were missed up to t = {time:.9g} s; "
        "the force is zero",
        help="take a cheaper method (`bgc trade`) or a longer step, or get real-time priority "
        "(`bgc doc BG766`)",
    )


def loop_stalled(time: float, watchdog: float, in_driver: bool) -> Diagnostic:
    """BG765: the loop stopped responding"""
    where = " in a call of a driver, which alone can set the force to zero" if in_driver else ""
    return error(
        "BG765",
        f"the loop did not run for {watchdog:.3g} s after t = {time:.9g} s{where}"
        + ("" if in_driver else "; the force is zero"),
        help='look for what does not return; `--watchdog "0.5 s"` allows more time',
    )


def not_realtime(refused: Sequence[str]) -> Diagnostic:
    """BG766: real-time priority or locked memory was refused"""
    return warning(
        "BG766",
        f"{' and '.join(refused)} refused: other programs may delay the loop",
        help="put `@haptic - rtprio 90` and `@haptic - memlock unlimited` into "
        "/etc/security/limits.d/90-haptic.conf, join that group and log in again",
    )


def deadlines_missed(
    missed: int, samples: int, policy: str, effect: str, has_priority: bool
) -> Diagnostic:
    """BG767: deadlines were missed"""
    return warning(
        "BG767",
        f"{missed:,} of {samples:,} deadlines missed, policy {policy}{effect}",
        help="take a cheaper method (`bgc trade`) or a longer step"
        if has_priority
        else "get real-time priority (`bgc doc BG766`), or take a cheaper method (`bgc trade`)",
    )


def records_lost(count: int) -> Diagnostic:
    """BG768: a recording has gaps, or ended early"""
    return warning(
        "BG768",
        f"the recording lacks {count:,} samples: nobody took them in time",
        help="a replay will differ; record to a faster disk",
    )


def recording_ended(path: str, reason: str) -> Diagnostic:
    """The same code, where a file cannot be written."""
    return warning(
        "BG768",
        f"the recording `{path}` ended early: {reason}; the loop went on",
        help="record to a disk with room",
    )


def cannot_start(reason: str) -> Diagnostic:
    """BG769: the loop cannot start"""
    return error(
        "BG769", f"the loop cannot start: {reason}", help="change the scene or the option named"
    )


def thread_left(seconds: float) -> Diagnostic:
    """BG775: the loop did not end"""
    return error(
        "BG775",
        f"the loop did not end within {seconds:.3g} s: a call of its driver does not return",
        help="end the process, and make the driver's `read` and `write` return at once",
    )


def unknown_policy(span: Span, given: str) -> Diagnostic:
    """BG776: an overrun policy that does not exist"""
    return error(
        "BG776",
        f"`{given}` is not an overrun policy",
        span,
        help="write `hold` (leave periods out), `skip` (catch up without the device) or `slow` "
        "(let simulated time run slower)",
    )


def no_pointer(device: str | None, have: Sequence[str]) -> Diagnostic:
    """BG777: no device takes a pose from Python"""
    if not have:
        text = "no device can take this pose: none has the driver `pointer`"
    elif device is None:
        text = f"no one device can take this pose: there are several: {', '.join(have)}"
    else:
        text = f"`{device}` cannot take this pose: it is no pointer, as {', '.join(have)} is"
    return error(
        "BG777",
        text,
        help='`model.realtime(devices={"hand": "pointer"})`; '
        '`pointer(.., device="hand")` where there are several',
    )


def python_device_failed(device: str, reason: str) -> Diagnostic:
    """BG779: a device that is a Python object failed"""
    return error(
        "BG779",
        f"device `{device}`, a Python object, failed: {reason}",
        help="`read()` returns a mapping with `position` and so on; `write(..)` is optional",
    )


def not_passive(device: str, needed: float, damping: float, stiffness: float) -> Diagnostic:
    """BG780: a loop that needs more damping than a hand and a device have"""
    have = f"the device has {damping:.3g}" if damping else "more than a hand and a device have"
    return warning(
        "BG780",
        f"the force on `{device}` ({stiffness:.4g} N/m) needs a damping of {needed:.4g} N*s/m "
        f"to be passive; {have}",
        help="lower the stiffness, sample faster, or use the guard `SampledPort` or `Observer`",
    )


def loop_grows(device: str, growth: float, period: float) -> Diagnostic:
    """BG781: a loop that grows with the mass of its device"""
    rate = (growth - 1.0) / period
    return warning(
        "BG781",
        f"the loop with `{device}` grows by a factor of {growth:.4g} each sample ({rate:.3g} 1/s)",
        help="lower the stiffness, sample faster, or shorten the lag",
    )


def unknown_lag(device: str, port: str, lag: int, known: float, echoes: bool) -> Diagnostic:
    """BG782: a sampled port behind a network that it does not know"""
    what = (
        f"has a delay of {lag} samples, the sampled port `{port}` a lag of {known:g}"
        if lag > known
        else f"does not say which force it held, and the sampled port `{port}` relies on it"
    )
    return warning(
        "BG782",
        f"`{device}` {what}",
        help="set the `lag` of the port to the longest delay, and let the device send its work"
        if not echoes
        else "set the `lag` of the port to the longest delay",
    )


def lag_exceeded(device: str, lag: float, late: int, samples: int) -> Diagnostic:
    """BG783: a device answered later than it states"""
    return warning(
        "BG783",
        f"`{device}` answered up to {lag:.3g} samples late, in {late:,} of {samples:,} samples "
        "later than it states",
        help=f"state `lag = {math.ceil(lag)}` in the device and in its sampled port",
    )
