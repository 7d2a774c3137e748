"""Diagnostics: servo loops and their devices."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, warning
from bgc.diagnostics.source import Span


@error(
    "BG762: device `{device}` gave a value that is not finite at t = {time:.9g} s; its force "
    "is zero",
    "check the device with its maker's tools, then its driver",
)
def bad_pose(time: float, device: str) -> None: ...
@error(
    "BG778: device `{device}` gave a pose that no hand can have at t = {time:.9g} s: {reason}; its "
    "force is zero",
    'check the device with its maker\'s tools; `--max-speed "10 m/s"`, `--max-turn-rate` and '
    "`--workspace-margin` allow more",
)
def implausible_pose(time: float, device: str, reason: str) -> None: ...
@error(
    "BG763: device `{device}` gave nothing new for {stale:.3g} s (t = {time:.9g} s){why}; its "
    "force is zero",
    'check the device and what sends its data; `--stale "0.5 s"` allows more time',
)
def device_stuck(time: float, device: str, stale: float, reason: str) -> Values:
    return {"why": f": {reason}" if reason else ""}


@error(
    "BG764: {missed:,} of {samples:,} deadlines were missed up to t = {time:.9g} s; the "
    "force is zero",
    "take a cheaper method (`bgc trade`) or a longer step, or get real-time priority "
    "(`bgc doc BG766`)",
)
def too_late(time: float, missed: int, samples: int) -> None: ...
@error(
    "BG765: the loop did not run for {watchdog:.3g} s after t = {time:.9g} s{where}",
    'look for what does not return; `--watchdog "0.5 s"` allows more time',
)
def loop_stalled(time: float, watchdog: float, in_driver: bool) -> Values:
    in_call = " in a call of a driver, which alone can set the force to zero"
    return {"where": in_call if in_driver else "; the force is zero"}


@warning(
    "BG766: {options} refused: other programs may delay the loop",
    "put `@haptic - rtprio 90` and `@haptic - memlock unlimited` into "
    "/etc/security/limits.d/90-haptic.conf, join that group and log in again",
)
def not_realtime(refused: Sequence[str]) -> Values:
    return {"options": " and ".join(refused)}


@warning(
    "BG767: {missed:,} of {samples:,} deadlines missed, policy {policy}{effect}",
    "{first}take a cheaper method (`bgc trade`){second}",
)
def deadlines_missed(
    missed: int, samples: int, policy: str, effect: str, has_priority: bool
) -> Values:
    if has_priority:
        return {"first": "", "second": " or a longer step"}
    return {"first": "get real-time priority (`bgc doc BG766`), or ", "second": ""}


@warning(
    "BG768: the recording lacks {count:,} samples: nobody took them in time",
    "a replay will differ; record to a faster disk",
)
def records_lost(count: int) -> None: ...
# The same code, where a file cannot be written.
@warning(
    "BG768: the recording `{path}` ended early: {reason}; the loop went on",
    "record to a disk with room",
)
def recording_ended(path: str, reason: str) -> None: ...
@error("BG769: the loop cannot start: {reason}", "change the scene or the option named")
def cannot_start(reason: str) -> None: ...
@error(
    "BG775: the loop did not end within {seconds:.3g} s: a call of its driver does not return",
    "end the process, and make the driver's `read` and `write` return at once",
)
def thread_left(seconds: float) -> None: ...
@error(
    "BG776: `{given}` is not an overrun policy",
    "write `hold` (leave periods out), `skip` (catch up without the device) or `slow` "
    "(let simulated time run slower)",
)
def unknown_policy(span: Span, given: str) -> None: ...
@error(
    "BG777: {problem}",
    '`model.realtime(devices={"hand": "pointer"})`; `pointer(.., device="hand")` where '
    "there are several",
)
def no_pointer(device: str | None, have: Sequence[str]) -> Values:
    if not have:
        return {"problem": "no device can take this pose: none has the driver `pointer`"}
    names = ", ".join(have)
    if device is None:
        return {"problem": f"no one device can take this pose: there are several: {names}"}
    return {"problem": f"`{device}` cannot take this pose: it is no pointer, as {names} is"}


@error(
    "BG779: device `{device}`, a Python object, failed: {reason}",
    "`read()` returns a mapping with `position` and so on; `write(..)` is optional",
)
def python_device_failed(device: str, reason: str) -> None: ...
@warning(
    "BG759: no driver could confirm zero force in the end: the device is lost, or does not open "
    "again",
    "the time guard of the device has to act; switch it off, and look at what its driver reported",
)
def zero_not_confirmed() -> None: ...
@warning(
    "BG780: the force on `{device}` ({stiffness:.4g} N/m) needs a damping of {needed:.4g} N*s/m "
    "to be passive, {of_stiffness:.4g} of it for the stiffness; {have}",
    "lower the {term}, sample faster, or use the guard `SampledPort` or `Observer`",
)
def not_passive(
    device: str, needed: float, of_stiffness: float, damping: float, stiffness: float
) -> Values:
    have = f"the device has {damping:.3g}" if damping else "more than a hand and a device have"
    damper = needed > 2.0 * of_stiffness
    term = "damping of the coupling (it decides here)" if damper else "stiffness"
    return {"have": have, "term": term}


@warning(
    "BG781: the loop with `{device}` grows by a factor of {growth:.4g} each sample "
    "({rate:.3g} 1/s)",
    "lower the stiffness, sample faster, or shorten the lag",
)
def loop_grows(device: str, growth: float, period: float) -> Values:
    return {"rate": (growth - 1.0) / period}


@warning("BG782: `{device}` {fault}", "set the `lag` of the port to the longest delay{more}")
def unknown_lag(device: str, port: str, lag: int, known: float, echoes: bool) -> Values:
    fault = f"does not say which force it held, and the sampled port `{port}` relies on it"
    if lag > known:
        fault = f"has a delay of {lag} samples, the sampled port `{port}` a lag of {known:g}"
    return {"fault": fault, "more": "" if echoes else ", and let the device send its work"}


@warning(
    "BG783: `{device}` answered up to {lag:.3g} samples late, in {late:,} of {samples:,} "
    "samples later than it states",
    "state `lag = {steps}` in the device and in its sampled port",
)
def lag_exceeded(device: str, lag: float, late: int, samples: int) -> Values:
    return {"steps": math.ceil(lag)}
