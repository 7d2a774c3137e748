"""Diagnostics of scenes: devices, drives, observed columns, options of a run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, respelt
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def unknown_scene(name: str, scenes: Sequence[str]) -> Diagnostic:
    """BG600: a scene that the file does not have

    What: the file has no scene with the name after `--scene`.

    Why: scenes of imported files are not available here.

    Example: `bgc run crane.bg --scene stormy`

    Way out: name one of the file's scenes; without `--scene` the first one runs.
    """
    listing = ", ".join(f"`{s}`" for s in scenes)
    near = did_you_mean(name, scenes)
    return error(
        "BG600",
        f"there is no scene `{name}`",
        help=near
        or (
            f"name a scene of the file: {listing}"
            if listing
            else "omit `--scene`: the file has no scenes"
        ),
    )


def nothing_to_run(name: str) -> Diagnostic:
    """BG601: a file without a model

    What: the file declares neither a scene nor a model.

    Why: there is nothing to compile; imported models do not run by themselves.

    Example: a file with only `import "parts.bg";`.

    Way out: add a model, or a scene of an imported model.
    """
    return error(
        "BG601", f"`{name}` declares no model and no scene", help="add `scene s of Model { .. }`"
    )


def only_dimensioned(span: Span, name: str) -> Diagnostic:
    """BG602: a model with dimensions and no scene

    What: the file has no scene, and its last model needs dimensions.

    Why: the dimensions are unknown.

    Example: `model Chain[n] { }` alone in a file.

    Way out: write a scene: `scene s of Chain[20] { .. }`.
    """
    return error(
        "BG602",
        f"model `{name}` needs dimensions to be run",
        span,
        help=f"write `scene s of {name}[..] {{ .. }}`",
    )


def edit_without_target(
    span: Span, path: str, what: str, found: str = "", way: str = ""
) -> Diagnostic:
    """BG603: a `set`, `use` or `drive` of the wrong kind of target

    What: the path names something of another kind: `set` takes a parameter or constant, `use` a
    slot, `drive` an input or a device's command.

    Why: the model defines all other values.

    Example: `set pendulum.angle = 30 deg;` where `state angle = angle0;`

    Way out: name a target of the right kind, here the parameter `angle0`, or declare one in the
    model.
    """
    other = f"{found}, not {what}" if found else f"not {what}"
    return error("BG603", f"`{path}` is {other}", span, help=way or f"name {what} of the model")


def unknown_channel(span: Span, name: str, device: str, have: Iterable[str]) -> Diagnostic:
    """BG610: a channel that the device does not have

    What: the name after a device is not one of its channels.

    Why: a device provides `position orientation velocity angular_velocity gripper buttons`, and
    receives `force torque gripper_force`.

    Example: `drive handle.x = hand.positon;`

    Way out: correct the name.
    """
    have = list(have)
    listing = ", ".join(f"`{h}`" for h in have)
    return error(
        "BG610",
        f"device `{device}` has no channel `{name}` here",
        span,
        help=did_you_mean(name, have) or f"use one of its channels: {listing}",
        edits=respelt(span, name, have),
    )


def device_name_taken(span: Span, name: str, first: Span | None) -> Diagnostic:
    """BG611: a device whose name is already in use

    What: another device of the scene, or a part or value of its model, has the name of this device.

    Why: `hand.position` would be ambiguous.

    Example: `device handle = trace(file = "a.csv");` where the model has a part `handle`.

    Way out: give the device another name.
    """
    labels = [Label(first, "already declared here")] if first else []
    return error("BG611", f"the name `{name}` is taken", span, labels=labels,
                 help="give the device another name")  # fmt: skip


def device_option(span: Span, name: str, needed: str = "") -> Diagnostic:
    """BG612: an invalid option of a device or solver

    What: an option has no name, its value is neither a number nor a quoted text, or an option that
    the driver needs is not given.

    Why: options are passed to the driver unchanged.

    Example: `device hand = trace(hand.csv);`

    Way out: write `trace(file = "hand.csv")`.
    """
    return error(
        "BG612",
        f"{name} needs the option `{needed}`"
        if needed
        else f"{name} takes options of the form `name = value`",
        span,
        help='give a number or a quoted text: `trace(file = "hand.csv")`',
    )


def observe_needs_name(span: Span) -> Diagnostic:
    """BG620: an observed expression without a name

    What: an observed expression is not a plain path and has no `as`.

    Why: its column needs a name.

    Example: `observe spring.e / damper.f;`

    Way out: write `observe spring.e / damper.f as ratio;`
    """
    return error("BG620", "an observed expression needs a name", span, help="write `.. as name`")


def column_twice(span: Span, name: str, first: Span) -> Diagnostic:
    """BG621: two columns with the same name

    What: two observed quantities have the same name.

    Why: the name identifies a column of the result.

    Example: `observe a.f as flow, b.f as flow;`

    Way out: rename one with `as`.
    """
    return error(
        "BG621",
        f"two columns are called `{name}`",
        span,
        labels=[Label(first, "the first one")],
        help="rename one with `as`",
    )


def unknown_account(span: Span, name: str, have: Sequence[str]) -> Diagnostic:
    """BG622: an energy account that does not exist

    What: the name after `energy` is not one of the accounts.

    Why: the accounts are `stored`, `supplied`, `dissipated` and their `residual`.

    Example: `observe energy.kinetic;`

    Way out: observe one of the four; for the power of a part observe `part.power`.
    """
    listing = ", ".join(f"`energy.{h}`" for h in have)
    return error(
        "BG622",
        f"there is no energy account `{name}`",
        span,
        help=did_you_mean(name, have) or f"use one of {listing}",
        edits=respelt(span, name, have),
    )


def unit_of_column(span: Span, unit: str, quantity: str) -> Diagnostic:
    """BG490: a column in a unit of another quantity

    What: the unit after `in` does not measure the observed value.

    Why: a length has no value in degrees. The column `x [unit]` holds the value in that unit.

    Example: `observe tip.z in deg;`

    Way out: write a unit of the same quantity, such as `mm` for a length.
    """
    return error(
        "BG490",
        f"a column in `{unit}` cannot hold {quantity}",
        span,
        help="write a unit of the same quantity, or omit `in` for SI units",
    )


def plot_unobserved(span: Span, name: str, columns: Sequence[str]) -> Diagnostic:
    """BG623: a plot of an unobserved quantity

    What: `plot` names something that is not a column of the scene.

    Why: a scene computes and plots only the quantities that it observes.

    Example: `observe boom.f; plot tip.z;`.

    Way out: add `observe tip.z;`, or plot one of the observed names.
    """
    return error(
        "BG623",
        f"`{name}` is plotted, but the scene does not observe it",
        span,
        help=did_you_mean(name, columns) or f"add `observe {name};`",
        edits=respelt(span, name, columns),
    )


def unknown_option(span: Span, name: str, have: Sequence[str]) -> Diagnostic:
    """BG632: an option that solvers do not have

    What: the name given to a solver in parentheses is not one of its options.

    Why: ignoring an unknown option would silently change the accuracy.

    Example: `solver rodas5p(tolerance = 1e-6);`

    Way out: use `rtol` and `atol` for tolerances, `step` for a fixed step, `max_step` and
    `max_steps` as limits, `keep` for the number of steps that share a Jacobian, `substeps` for the
    parts of a fixed step whose error is too large, or `settle` for the frequency above which modes
    start at rest.
    """
    listing = ", ".join(f"`{h}`" for h in have)
    return error(
        "BG632",
        f"solvers have no option `{name}`",
        span,
        help=did_you_mean(name, have) or f"use one of {listing}",
        edits=respelt(span, name, have),
    )


def not_positive(span: Span, what: str, value: float) -> Diagnostic:
    """BG630: a time or tolerance that is not positive

    What: a duration, step, deadline or tolerance is zero or negative.

    Why: such a value has no meaning.

    Example: `run 0 s;`

    Way out: give a positive value.
    """
    return error(
        "BG630",
        f"{what} is {value:g}, but must be positive",
        span,
        help="give a positive value; a time without a unit is in seconds",
    )


def said_twice(span: Span, what: str, first: Span) -> Diagnostic:
    """BG631: a statement given twice in a scene

    What: a scene has two `run`, `step`, `solver` or `deadline` statements.

    Why: the two may contradict each other.

    Example: `run 10 s; run 60 s;`

    Way out: remove one.
    """
    return error(
        "BG631",
        f"the scene has two `{what}` statements",
        span,
        labels=[Label(first, "the first one")],
        help="remove one of them",
    )


def hold_without_state(span: Span, path: str) -> Diagnostic:
    """BG465: a value to hold that no state determines

    What: `start rest hold` names a value of parameters, of the time or of devices alone.

    Why: a start at rest moves states; such a value stays whatever they are.

    Example: `start rest hold crane.boom.length;`

    Way out: hold an angle, a position or another value of states, or omit `hold`.
    """
    return error(
        "BG465",
        f"`{path}` does not depend on a state, so a start at rest cannot move it",
        span,
        help="hold a value of states, such as the angle of a joint, or omit it",
    )


def vary_without_parameter(span: Span, path: str) -> Diagnostic:
    """BG466: something to vary that is not a parameter

    What: `start rest vary` names something other than a parameter.

    Why: a start at rest may move all states; besides them only parameters can be chosen.

    Example: `start rest vary elbow.torque;` where `input torque = 0;`

    Way out: name a parameter. To vary an input, drive it by a parameter: `param hold = 0;` in the
    model, and `drive elbow.torque = hold;`.
    """
    return error(
        "BG466",
        f"`{path}` is not a parameter",
        span,
        help="name a parameter of the model, which the start may change",
    )
