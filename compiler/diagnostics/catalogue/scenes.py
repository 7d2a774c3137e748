"""Diagnostics of scenes: devices, drives, what is observed, how a run is made."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.diagnostics.catalogue import did_you_mean, error
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def unknown_scene(name: str, scenes: Sequence[str]) -> Diagnostic:
    """BG600: a scene that the file does not have

    What: `--scene` names no scene of the file.

    Why: scenes of imported files are not run from here.

    Example: `bgc run crane.bg --scene stormy`

    Way out: name one of the file's scenes; without `--scene` the first one runs.
    """
    listing = ", ".join(f"`{s}`" for s in scenes)
    near = did_you_mean(name, scenes)
    return error(
        "BG600",
        f"there is no scene `{name}`",
        help=near or (f"the file has {listing}" if listing else "the file has no scenes"),
    )


def nothing_to_run(name: str) -> Diagnostic:
    """BG601: a file without a model

    What: the file declares neither a scene nor a model of its own.

    Why: there is nothing to compile; imported models are not taken.

    Example: a file with only `import "parts.bg";`

    Way out: add a model, or a scene of an imported one.
    """
    return error(
        "BG601", f"`{name}` declares no model and no scene", help="add `scene s of Model { .. }`"
    )


def only_dimensioned(span: Span, name: str) -> Diagnostic:
    """BG602: a model with dimensions and no scene

    What: the file has no scene, and its last model needs dimensions.

    Why: how wide it is to be is not known.

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
    """BG603: a `set`, `use` or `drive` of something that does not take it

    What: the path names something of another kind: `set` takes a parameter or constant, `use` a
    slot, `drive` an input or a device's command.

    Why: everything else has its value from the model.

    Example: `set pendulum.angle = 30 deg;` where `state angle = angle0;`

    Way out: name a parameter, as `angle0`; or declare one in the model.
    """
    other = f"{found}, not {what}" if found else f"not {what}"
    return error("BG603", f"`{path}` is {other}", span, help=way or f"name {what} of the model")


def unknown_channel(span: Span, name: str, device: str, have: Iterable[str]) -> Diagnostic:
    """BG610: a channel that devices do not have

    What: the name after a device is none of its channels.

    Why: a device gives `position orientation velocity angular_velocity gripper buttons`, and
    takes `force torque gripper_force`.

    Example: `drive handle.x = hand.positon;`

    Way out: correct the name.
    """
    have = list(have)
    listing = ", ".join(f"`{h}`" for h in have)
    return error(
        "BG610",
        f"device `{device}` has no channel `{name}` here",
        span,
        help=did_you_mean(name, have) or f"its channels are {listing}",
    )


def device_name_taken(span: Span, name: str, first: Span | None) -> Diagnostic:
    """BG611: a device with a name that is taken

    What: the scene has another device, or its model a part or value, of that name.

    Why: `hand.position` could mean either.

    Example: `device handle = trace(file = "a.csv");` where the model has a part `handle`.

    Way out: call the device something else.
    """
    labels = [Label(first, "already here")] if first else []
    return error("BG611", f"the name `{name}` is taken", span, labels=labels,
                 help="call the device something else")  # fmt: skip


def device_option(span: Span, name: str) -> Diagnostic:
    """BG612: an option of a device or solver that is not understood

    What: an option has no name, or its value is neither a number nor a text in quotes.

    Why: options are handed to the driver as they are.

    Example: `device hand = trace(hand.csv);`

    Way out: write `trace(file = "hand.csv")`.
    """
    return error(
        "BG612",
        f"{name} takes options as `name = value`",
        span,
        help='a value is a number or a text in quotes: `trace(file = "hand.csv")`',
    )


def observe_needs_name(span: Span) -> Diagnostic:
    """BG620: an observed expression without a name

    What: an expression that is no plain path is observed without `as`.

    Why: its column needs a name.

    Example: `observe spring.e / damper.f;`

    Way out: write `observe spring.e / damper.f as ratio;`
    """
    return error("BG620", "an observed expression needs a name", span, help="write `.. as name`")


def column_twice(span: Span, name: str, first: Span) -> Diagnostic:
    """BG621: two columns of one name

    What: two observed things have the same name.

    Why: the columns of the result are told apart by name.

    Example: `observe a.f as flow, b.f as flow;`

    Way out: give one another name by `as`.
    """
    return error(
        "BG621",
        f"two columns are called `{name}`",
        span,
        labels=[Label(first, "the first one")],
        help="give one another name by `as`",
    )


def unknown_account(span: Span, name: str, have: Sequence[str]) -> Diagnostic:
    """BG622: an energy account that does not exist

    What: the name after `energy` is none of the accounts.

    Why: energy is kept as `stored`, `supplied`, `dissipated`, and their `residual`.

    Example: `observe energy.kinetic;`

    Way out: observe one of the four; a part's power is `part.power`.
    """
    listing = ", ".join(f"`energy.{h}`" for h in have)
    return error(
        "BG622",
        f"there is no energy account `{name}`",
        span,
        help=did_you_mean(name, have) or f"there are {listing}",
    )


def plot_unobserved(span: Span, name: str, columns: Sequence[str]) -> Diagnostic:
    """BG623: a plot of what the scene does not observe

    What: `plot` names something that is no column of the scene.

    Why: a scene computes only what it observes, and plots only what it computes.

    Example: `observe boom.f; plot tip.z;`.

    Way out: `observe tip.z;` too, or one of the names that the scene observes.
    """
    return error(
        "BG623",
        f"`{name}` is plotted, but the scene does not observe it",
        span,
        help=did_you_mean(name, columns) or f"add `observe {name};`",
    )


def unknown_option(span: Span, name: str, have: Sequence[str]) -> Diagnostic:
    """BG632: an option that solvers do not have

    What: the name given to a solver in parentheses is none of its options.

    Why: an option that is passed over would leave the accuracy other than asked for.

    Example: `solver rodas5p(tolerance = 1e-6);`

    Way out: use `rtol` and `atol` for the tolerances, `step` of a fixed-step method, `max_step`
    and `max_steps` as limits, `keep` for how many steps a Jacobian serves, `settle` for the
    frequency beyond which modes start at rest.
    """
    listing = ", ".join(f"`{h}`" for h in have)
    return error(
        "BG632",
        f"solvers have no option `{name}`",
        span,
        help=did_you_mean(name, have) or f"they have {listing}",
    )


def not_positive(span: Span, what: str, value: float) -> Diagnostic:
    """BG630: a time or tolerance that is not positive

    What: a duration, step, deadline or tolerance is zero or negative.

    Why: time runs forwards.

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
    """BG631: a scene that says something twice

    What: a scene has two `run`, `step`, `solver` or `deadline`.

    Why: which of them holds could not be told.

    Example: `run 10 s; run 60 s;`

    Way out: remove one.
    """
    return error(
        "BG631",
        f"the scene has two `{what}`",
        span,
        labels=[Label(first, "the first one")],
        help="remove one of them",
    )
