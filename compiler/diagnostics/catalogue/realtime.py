"""BG762-BG769 and BG775-BG783: the servo loop and its devices."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, warning
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


def bad_pose(time: float, device: str) -> Diagnostic:
    """BG762: a device gave a value that is not finite

    What: a position, velocity, orientation or button of a device was NaN or infinite. The force
    went to zero in the same period, and the loop ended; the state of the model is kept.

    Why: a sensor or its cable failed, or the driver divides by zero.

    Example: a driver that computes a velocity from two readings with the same time.

    Way out: check the device with its maker's tools, then the driver.
    """
    return error(
        "BG762",
        f"device `{device}` gave a value that is not finite at t = {time:.9g} s; its force is zero",
        help="check the device with its maker's tools, then its driver",
    )


def device_stuck(time: float, device: str, stale: float) -> Diagnostic:
    """BG763: a device gives no new data

    What: a device with motors gave no new measurement for some time. The last pose held until then;
    the force went to zero, and the loop ended.

    Why: the program of the device has stopped, or its cable or network is interrupted: the time
    stamp no longer changes.

    Example: the program that sends datagrams to the driver `udp` was stopped.

    Way out: check the device, or allow more time with `--stale "0.5 s"`.
    """
    return error(
        "BG763",
        f"device `{device}` gave nothing new for {stale:.3g} s (t = {time:.9g} s); "
        "its force is zero",
        help='check the device and what sends its data; `--stale "0.5 s"` allows more time',
    )


def too_late(time: float, missed: int, samples: int) -> Diagnostic:
    """BG764: too many deadlines in a row were missed

    What: the loop missed so many deadlines that a hand would feel a wrong force. The force went to
    zero, and the loop ended.

    Why: the model takes longer than a period, or other programs have the processor.

    Example: a crane at 4 kHz on a busy machine without real-time priority.

    Way out: a cheaper method (`bgc trade`), a longer step, real-time priority (see BG766), or
    `--burst 0` to continue in any case.
    """
    return error(
        "BG764",
        f"{missed:,} of {samples:,} deadlines were missed up to t = {time:.9g} s; "
        "the force is zero",
        help="take a cheaper method (`bgc trade`) or a longer step, or get real-time priority "
        "(`bgc doc BG766`)",
    )


def loop_stalled(time: float, watchdog: float, in_driver: bool) -> Diagnostic:
    """BG765: the loop stopped responding

    What: the loop took no sample for longer than the watchdog allows. The watchdog set the force to
    zero. If the loop hung inside a call of the driver, no other thread may call the driver, and the
    watchdog of the device itself has to act.

    Why: a step of the model or a call of the driver did not return, or the process was stopped.

    Example: a driver that waits for a network.

    Way out: make the driver's `read` and `write` return at once; `--watchdog "0.5 s"` allows more
    time.
    """
    where = " in a call of a driver, which alone can set the force to zero" if in_driver else ""
    return error(
        "BG765",
        f"the loop did not run for {watchdog:.3g} s after t = {time:.9g} s{where}"
        + ("" if in_driver else "; the force is zero"),
        help='look for what does not return; `--watchdog "0.5 s"` allows more time',
    )


def not_realtime(refused: Sequence[str]) -> Diagnostic:
    """BG766: real-time priority or locked memory was refused

    What: the loop runs, but other programs or the swapping of memory may delay it.

    Why: the system grants SCHED_FIFO and locked memory only to users with the right to them.

    Example: `bgc haptic` as a user for whom `ulimit -r` is 0.

    Way out: write `/etc/security/limits.d/90-haptic.conf` with the lines `@haptic - rtprio 90` and
    `@haptic - memlock unlimited`, join the group `haptic`, and log in again.
    """
    return warning(
        "BG766",
        f"{' and '.join(refused)} refused: other programs may delay the loop",
        help="put `@haptic - rtprio 90` and `@haptic - memlock unlimited` into "
        "/etc/security/limits.d/90-haptic.conf, join that group and log in again",
    )


def deadlines_missed(
    missed: int, samples: int, policy: str, effect: str, has_priority: bool
) -> Diagnostic:
    """BG767: deadlines were missed

    What: in some periods the work ended after the deadline. The overrun policy of the scene says
    what happened then.

    Why: the model takes too long, or other programs had the processor.

    Example: `deadline 1 ms, hold;` on a busy machine.

    Way out: real-time priority (BG766), a cheaper method (`bgc trade`), or a longer step.
    """
    return warning(
        "BG767",
        f"{missed:,} of {samples:,} deadlines missed, policy {policy}{effect}",
        help="take a cheaper method (`bgc trade`) or a longer step"
        if has_priority
        else "get real-time priority (`bgc doc BG766`), or take a cheaper method (`bgc trade`)",
    )


def records_lost(count: int) -> Diagnostic:
    """BG768: a recording has gaps, or ended early

    What: records of the loop were lost, so that a replay will not have the same bits.

    Why: the disk is full or slow, or the Python process was suspended. The loop itself went on.

    Example: `--record /dev/full`.

    Way out: record to a disk with room.
    """
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
    """BG769: the loop cannot start

    What: the loop was refused before its first sample.

    Why: the scene's step is shorter than 0.25 ms (4 kHz is the most), the method is that of another
    program, or the system gave no thread.

    Example: `step 0.1 ms;` with `bgc haptic`.

    Way out: follow the reason given.
    """
    return error(
        "BG769", f"the loop cannot start: {reason}", help="change the scene or the option named"
    )


def thread_left(seconds: float) -> Diagnostic:
    """BG775: the loop did not end

    What: the loop was asked to end and did not. Its thread is left behind until the process ends.

    Why: a call of a driver does not return.

    Example: a driver that waits for a network.

    Way out: make the driver's `read` and `write` return at once; end the process.
    """
    return error(
        "BG775",
        f"the loop did not end within {seconds:.3g} s: a call of its driver does not return",
        help="end the process, and make the driver's `read` and `write` return at once",
    )


def unknown_policy(span: Span, given: str) -> Diagnostic:
    """BG776: an overrun policy that does not exist

    What: the word behind the deadline is not one of the policies.

    Why: a loop that is late can leave periods out (`hold`), catch up (`skip`), or let simulated
    time run slower (`slow`).

    Example: `deadline 1 ms, wait;`.

    Way out: write `deadline 1 ms, hold;`, `skip` or `slow`.
    """
    return error(
        "BG776",
        f"`{given}` is not an overrun policy",
        span,
        help="write `hold` (leave periods out), `skip` (catch up without the device) or `slow` "
        "(let simulated time run slower)",
    )


def no_pointer(device: str | None, have: Sequence[str]) -> Diagnostic:
    """BG777: no device takes a pose from Python

    What: a pose was given to a loop in which no device, or more than one, has the driver `pointer`,
    or to a device that has another driver.

    Why: other drivers have poses of their own.

    Example: `realtime.pointer(position=..)` with `device hand = trace(..)`.

    Way out: open the device with that driver, `model.realtime(devices={"hand": "pointer"})`, and
    name the device if there are several.
    """
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
    """BG779: a device that is a Python object failed

    What: `read` or `write` of the object raised an exception, or returned no pose. The loop was
    stopped.

    Why: see the reason.

    Example: an object whose `read` returns None.

    Way out: `read()` returns a mapping with `position` and, if it has them, `orientation`,
    `velocity`, `angular_velocity`, `gripper`, `buttons`; `write(force, torque, gripper_force)` is
    optional.
    """
    return error(
        "BG779",
        f"device `{device}`, a Python object, failed: {reason}",
        help="`read()` returns a mapping with `position` and so on; `write(..)` is optional",
    )


def not_passive(device: str, needed: float, damping: float, stiffness: float) -> Diagnostic:
    """BG780: a loop that needs more damping than a hand and a device have

    What: the force of the model on a device depends on its position so stiffly that the loop is
    passive only with a damping b > K T/2 + |B| (with delay: as computed over all frequencies) that
    the device does not have; where it states none, above 30 N s/m. No guard acts.

    Why: a force that is held over a sample belongs to the position at which the hand was. The
    energy that it returns beyond what it took must be damped by the hand, otherwise the loop
    oscillates.

    Example: a wall of 2000 N/m at 1 ms with a device of 0.5 N s/m: it needs 1 N s/m.

    Way out: lower the stiffness, sample faster, or fill the slot of the coupling with
    `SampledPort`, which pays for that energy, or `Observer`.
    """
    have = f"the device has {damping:.3g}" if damping else "more than a hand and a device have"
    return warning(
        "BG780",
        f"the force on `{device}` ({stiffness:.4g} N/m) needs a damping of {needed:.4g} N*s/m "
        f"to be passive; {have}",
        help="lower the stiffness, sample faster, or use the guard `SampledPort` or `Observer`",
    )


def loop_grows(device: str, growth: float, period: float) -> Diagnostic:
    """BG781: a loop that grows with the mass of its device

    What: with the mass and the damping that a device states, the sampled loop of model and device,
    as linearised at the start, has a motion that grows.

    Why: the stiffness is above the limit for the masses of device and model at this period and lag:
    the parameters were changed after compiling, or the device is lighter than the model says.

    Example: a sampled port of 20000 N/m, compiled for a device of 0.25 kg, with one of 0.03 kg.

    Way out: lower the stiffness, or give the port the mass and the lag of the device.
    """
    rate = (growth - 1.0) / period
    return warning(
        "BG781",
        f"the loop with `{device}` grows by a factor of {growth:.4g} each sample ({rate:.3g} 1/s)",
        help="lower the stiffness, sample faster, or shorten the lag",
    )


def unknown_lag(device: str, port: str, lag: int, known: float, echoes: bool) -> Diagnostic:
    """BG782: a sampled port behind a network that it does not know

    What: a device states a delay of more samples than the `lag` of the model's sampled port, or a
    device with a delay does not send back the work of the force that it held.

    Why: the damping K T (lag + 1) of the port compensates the delay, so it needs the longest one.
    Its energy account is exact for the force that the hand held; with a delay, that is not the
    force that was sent last.

    Example: `device hand = udp(port = 5005, lag = 40);` and a coupling with `lag = 0`.

    Way out: set the port's `lag` to that of the device; send poses of version 2, with the work.
    """
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
    """BG783: a device answered later than it states

    What: a device measures how old the pose is that its force answers, and in some samples that was
    more than the `lag` that it states. The loop went on.

    Why: the network is slower, loses more packets in a row or delays them more than was assumed.
    The damping K T (lag + 1) of a sampled port compensates the lag that it was given. Beyond that
    lag the energy is still accounted exactly, and the brake of the port removes the excess.

    Example: `device hand = udp(port = 5005, lag = 5);` behind a link of 20 ms.

    Way out: state the largest lag that was measured, in the device and in the port.
    """
    return warning(
        "BG783",
        f"`{device}` answered up to {lag:.3g} samples late, in {late:,} of {samples:,} samples "
        "later than it states",
        help=f"state `lag = {math.ceil(lag)}` in the device and in its sampled port",
    )
