"""Diagnostics of causality and algebraic loops."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from bgc.diagnostics.catalogue import error, listed, underlined, warning
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


@dataclass(frozen=True, slots=True)
class Connection:
    """An element on a path between others: its name, its kind (`J0`, `TF`, ..), its place."""

    name: str
    kind: str
    span: Span


def causal_conflict(
    first: Connection, second: Connection, what: str, between: Sequence[Connection]
) -> Diagnostic:
    """BG501: two sources prescribe the same variable

    What: two sources set the same flow, or the same effort, along a rigid path of junctions and
    transformers.
    Why: each imposes its own value: there is no solution unless the two always agree, and then the
    share of each is undetermined.
    Example: two `Se` on one `J0`.
    Way out: remove one of the sources, or put an R (the inner resistance of a source) or a C
    between them.
    """
    labels = [Label(first.span, f"`{first.name}` sets {_set_by(first)} here")]
    variable = _set_by(first)
    for connection in between:
        if connection.kind == "GY":
            variable = "the flow" if variable == "the effort" else "the effort"
        labels.append(Label(connection.span, _passing(connection, variable)))
    labels.append(Label(second.span, f"`{second.name}` sets {_set_by(second)} too"))
    way = [first.name, *(connection.name for connection in between), second.name]
    return error(
        "BG501",
        f"`{first.name}` and `{second.name}` both set the same {what}",
        second.span,
        note=f"they are connected through {' - '.join(_shortened(way))}",
        labels=underlined(labels),
        help="remove one of them, or put an R or a C between them",
    )


def _set_by(source: Connection) -> str:
    return "the effort" if source.kind == "Se" else "the flow"


def _passing(connection: Connection, variable: str) -> str:
    """Describe the effect of a rigid connection on the variable that passes through it."""
    match connection.kind, variable:
        case ("J0", "the effort") | ("J1", "the flow"):
            return f"`{connection.name}` has one {variable[4:]}"
        case (("J0" | "J1"), _):
            return f"{variable}s add up at `{connection.name}`"
        case "GY", _:
            return f"`{connection.name}` turns it into {variable}"
        case _:
            return f"`{connection.name}` passes on {variable}"


def _shortened(way: Sequence[str]) -> list[str]:
    """Shorten a path of more than nine names by leaving out its middle."""
    if len(way) <= 9:
        return list(way)
    return [*way[:4], f"({len(way) - 8} more)", *way[-4:]]


def rigid_chain(
    span: Span, transformers: Sequence[Connection], others: Sequence[Connection]
) -> Diagnostic:
    """BG502: a closed chain of rigid connections

    What: junctions and transformers form a closed chain whose flows could only be found by dividing
    by a modulus that depends on the state and may become zero. Besides, something that the chain
    moves has no inertia, or the chain consists of efforts, behind a gyrator.
    Why: where the modulus is zero the chain locks or loses its drive, and equations that divide by
    it are wrong without a warning. A chain that moves inertias only is kept closed by reactions
    instead. The compiler divides by a modulus only if its range excludes zero, as that of `2 +
    sin(angle)` does.
    Example: a crank without mass that a driven rod turns.
    Way out: give all parts of the chain inertia, or make one joint compliant: use a C with an R in
    parallel.
    """
    through = _names_of(transformers or others)
    labels = [Label(c.span, f"the modulus of `{c.name}` is in the chain") for c in transformers] + [
        Label(c.span, f"`{c.name}` is in the chain") for c in others
    ]
    return error(
        "BG502",
        f"a closed chain of rigid connections through {listed(through)}",
        span,
        note=f"the chain also passes {listed(_names_of(others))}"
        if transformers and others
        else "",
        labels=underlined(labels),
        help="give all parts of it inertia, or make one of the connections compliant: use a C with "
        "an R in parallel",
    )


def _names_of(connections: Sequence[Connection]) -> list[str]:
    """List the names once each: components of a wide element may share a name."""
    return list(dict.fromkeys(connection.name for connection in connections))


def zero_modulus(span: Span, name: str) -> Diagnostic:
    """BG503: a modulus that is zero

    What: the flows around a transformer or gyrator could only be found by dividing by its modulus,
    and the modulus is zero for the given parameters.
    Why: a transformer or gyrator with modulus zero transmits nothing.
    Example: `param n = 0; gear : TF(n);`
    Way out: give the parameters a value that makes the modulus nonzero, or remove the element.
    """
    return error(
        "BG503",
        f"the modulus of `{name}` is zero",
        span,
        help="give its parameters a value that makes it nonzero, or remove the element",
    )


def redundant_structure(span: Span, names: Sequence[str]) -> Diagnostic:
    """BG504: a redundant connection

    What: a constraint that a junction or transformer puts on the flows already follows from other
    connections.
    Why: the share of each parallel connection in the effort between them is undetermined.
    Example: two `J0` joined by two bonds.
    Way out: remove one of the parallel connections. If the share does not matter, the warning can
    be ignored.
    """
    return warning(
        "BG504",
        f"{listed(names)} constrain the same flow twice: their shares of the effort are "
        "undetermined",
        span,
        help="remove one of the parallel connections",
    )


def bond_loop(span: Span, name: str) -> Diagnostic:
    """BG505: a loop of bonds between junctions

    What: a bond closes a loop of junctions of one kind.
    Why: any amount can circulate in the loop without an effect elsewhere.
    Example: two `J1` joined by two bonds.
    Way out: remove the bond, or merge the junctions into one.
    """
    return warning(
        "BG505",
        f"the bond `{name}` closes a loop of junctions: the flow or effort around it is "
        "undetermined",
        span,
        help="remove the bond, or merge the junctions into one",
    )


def nothing_determines(span: Span, name: str, what: str) -> Diagnostic:
    """BG506: a variable that nothing determines

    What: the model leaves a flow or effort open that is observed or needed.
    Why: no element at these bonds stores, dissipates or supplies energy, or the variable can
    circulate freely.
    Example: the flow of a `J1` whose two bonds lead to the same `J0`.
    Way out: connect an element to the junction, or do not observe the variable.
    """
    return error(
        "BG506",
        f"nothing determines the {what} of `{name}`",
        span,
        help="connect an element there, or do not observe the variable",
    )


def indeterminate(span: Span, name: str, what: str) -> Diagnostic:
    """BG507: a part of the graph without an element

    What: no element at these bonds stores, dissipates or supplies energy.
    Why: the flow or effort there is undetermined; it has no effect elsewhere.
    Example: two junctions that are bonded only to each other.
    Way out: connect an element, or remove the junctions.
    """
    return warning(
        "BG507",
        f"nothing determines the {what} of `{name}`",
        span,
        help="connect an element there, or remove the junction",
    )


def source_without_load(span: Span, name: str, what: str) -> Diagnostic:
    """BG508: a source without a load

    What: a source sets the effort of a junction of common flow, or the flow into a junction of
    common effort, and no other element is connected there.
    Why: the first is a short circuit, the second an open circuit: the other variable has no finite
    value.
    Example: `supply : Se(e = 5 V); loop : J1; supply -> loop;`
    Way out: connect a load to the junction: an R, I or C. A source whose value depends on that
    variable (`MSf(f = g*(a - node.e))`) is its own load.
    """
    return error(
        "BG508",
        f"`{name}` sets the {what} of a junction without a load",
        span,
        help="connect an R, I or C to the junction",
    )


def singular_loop(
    span: Span,
    bonds: Sequence[str],
    elements: Sequence[str],
    solutions: str,
    places: Sequence[Label] = (),
) -> Diagnostic:
    """BG520: an algebraic loop without a unique solution

    What: variables depend on each other in a loop, and its equations have no solution or infinitely
    many. The message names the case if it is known.
    Why: the terms of the loop cancel, for example with a feedback gain of exactly one. The
    remaining equation is a contradiction, or it is always true.
    Example: `MSe(e = junction.f * R)` that cancels a resistance R. With a capacitor on the same
    junction there is no solution; with nothing else there any flow is a solution.
    Way out: break the loop with a storage element, or change the values in it.
    """
    which = {
        "none": "has no solution",
        "many": "has infinitely many solutions",
        "unclear": "has no solution or infinitely many",
    }[solutions]
    note = f"the laws in the loop are those of {listed(elements)}" if elements else ""
    return error(
        "BG520",
        f"the algebraic loop through {listed(bonds)} {which}",
        span,
        note=note,
        labels=underlined(places),
        help="break the loop with a storage element, or change the terms that cancel",
    )


def derivative_loop(span: Span, names: Sequence[str]) -> Diagnostic:
    """BG521: a loop through the rate of a dependent variable

    What: the effort of a dependent inertia influences the momentum whose rate it is (or the flow of
    a dependent compliance its charge).
    Why: the rate of the momentum then depends on itself, so that no state gives the momentum.
    Example: a lever driven by an `Sf` whose ratio follows the inertia force of the mass behind it.
    Way out: take the signal from another element, or put a C between. Two similar models have
    equations and compile: an effort that follows an inertia force adds to the inertia, and a source
    that follows its own reaction (`MSf(f = g*(a - body.e))`) is a resistance.
    """
    return error(
        "BG521",
        f"the reaction at {listed(names)} depends on itself",
        span,
        help="take the signal from another element, or put a C between them",
    )


def rate_unknown(span: Span, name: str) -> Diagnostic:
    """BG522: an unknown rate

    What: an effort or flow depends on the rate of change of a device's input or of an unknown of an
    algebraic loop.
    Why: a sampled input has no rate, and the rate of a loop's unknown is not computed.
    Example: the force of an `Sf` driven by a device on a rigid mass.
    Way out: put a virtual coupling (a C with an R in parallel) behind the device, or do not observe
    the variable or the supplied energy.
    """
    return error(
        "BG522",
        f"the reaction at `{name}` needs an unknown rate",
        span,
        note="it is rigidly coupled to a device's input or to an unknown of an algebraic loop",
        help="put a C with an R in parallel in between, or do not observe the variable",
    )


def gyrator_loop(gyrators: Sequence[Connection], bonds: Sequence[str]) -> Diagnostic:
    """BG523: an odd loop of gyrators that cannot be solved

    What: a loop with an odd number of gyrators leaves one direction of flow undetermined: neither
    the gyrators, nor storage, nor a resistance fixes it. Or it could only be found by dividing by
    moduli that may become zero.
    Why: the balance in that direction then constrains only the sources, so it holds either never or
    always. (Storage in the loop avoids this: the stored quantities are merged.)
    Example: three gyrators in a ring between three junctions that carry only an `Se` each.
    Way out: put an R, C or I into the loop, as every real loop has, or remove a gyrator.
    """
    first, *others = gyrators
    return error(
        "BG523",
        f"the odd loop of gyrators through {listed([g.name for g in gyrators])} cannot be solved",
        first.span,
        labels=[Label(g.span, f"`{g.name}` is in the loop") for g in others],
        note=f"it leaves {listed(bonds)} undetermined",
        help="put an R, C or I into the loop, or remove one of the gyrators",
    )


def not_invertible(span: Span, variable: str, elements: Sequence[str], why: str) -> Diagnostic:
    """BG524: a law that cannot be inverted

    What: a law computes a variable that the graph already gives, so it must be inverted. It has the
    same value for an argument and its opposite, or over a whole range.
    Why: the inverse would have two or infinitely many values.
    Example: `R { e = k*f^2; }` on a junction where a source sets the effort, or a valve with a
    closed range where a source sets the flow.
    Way out: write the law with its sign (`k*f*abs(f)`), add a small leak where it is flat, or write
    it the other way round (`f = ...` instead of `e = ...`).
    """
    return error(
        "BG524",
        f"the law of {listed(elements)} cannot be inverted: it is {why}",
        span,
        note=f"it would have to give `{variable}`",
        help="write the law with its sign, for example `f*abs(f)`, give it a small slope, or write "
        "it the other way round",
    )


def singular_equations(
    span: Span, names: Sequence[str], solutions: str = "unclear", others: Sequence[Span] = ()
) -> Diagnostic:
    """BG531: equations that do not determine their unknowns

    What: the equations of some unknowns have no solution, infinitely many, or no unknown left for
    one of them. The message names the case if it is known.
    Why: equations contradict or repeat each other, whatever the values of parameters; a function
    that is constant between its jumps, such as `sign(z)`, does not determine `z`; or an equation is
    a constraint between states, without an unknown or a rate (see the example).
    Example: the force T in a pendulum's rod, from the length of the rod:
    `der(x) = vx;  der(vx) = -T*x;  der(y) = vy;  der(vy) = -T*y - g;  equation x^2 + y^2 = l^2;`.
    The constraint does not hold T, nor does its derivative, `x*vx + y*vy = 0`. The second
    derivative does: `equation vx^2 + vy^2 - T*(x^2 + y^2) - g*y = 0;` determines T.
    Way out: correct or replace one of the equations that the message marks. Replace a constraint
    between states by its first derivative that holds an unknown (the message gives it where it is
    short), and give the states initial values that satisfy the constraint and its lower
    derivatives. Or replace the constraint by a stiff spring: `T = k*(x^2 + y^2 - l^2)`.
    """
    message, help = {
        "none": (
            f"the equations for {listed(names)} have no solution: they contradict each other",
            "correct one of the equations; another factor or term makes it independent",
        ),
        "many": (
            f"the equations for {listed(names)} repeat each other: infinitely many values "
            "satisfy them",
            "replace one of the equations by an independent one",
        ),
        "unclear": (
            f"the equations do not determine {listed(names)}",
            "replace one of the equations by an independent one",
        ),
        "unpaired": (
            f"the equations do not determine {listed(names)}",
            f"let one of the equations hold {listed(names)}",
        ),
    }[solutions]
    labels = underlined([Label(other, "depends on this equation") for other in others])
    return error("BG531", message, span, labels=labels, help=help)


def equation_without_unknown(
    span: Span,
    names: Sequence[str],
    constant_in: Sequence[str],
    derivative: tuple[int, str] | None,
) -> Diagnostic:
    """BG531, of an equation that varies with no unknown: a constraint between states, usually.

    `constant_in` are unknowns that it holds, but does not vary with. `derivative` is its first
    derivative that holds an unknown, with its order.
    """
    message = f"the equations do not determine {listed(names)}"
    if constant_in:
        note = f"this equation is constant in {listed(constant_in)}, but for jumps"
        help = "let it vary with its unknown: by a steep slope such as `tanh(z/0.01)` for `sign(z)`"
        return error("BG531", message, span, note=note, help=help)
    note = "this equation varies with no unknown and no rate that it could determine"
    if derivative is None:
        help = (
            "let it hold an unknown; differentiate a constraint between states until it does: "
            "`x^2 + y^2 = l^2` becomes `x*vx + y*vy = 0`, whose derivative holds the force"
        )
        return error("BG531", message, span, note=note, help=help)
    order, equation = derivative
    times = ("", "twice ", "three times ")[order - 1]
    lower = (
        "the constraint",
        "the constraint and its first derivative",
        "the constraint and its first two derivatives",
    )[order - 1]
    help = (
        f"differentiate it {times}in time: `equation {equation};`, and give the states initial "
        f"values that satisfy {lower}; or replace it by a stiff spring"
    )
    return error("BG531", message, span, note=note, help=help)


def invalid_initial(span: Span | None, name: str) -> Diagnostic:
    """BG532: an initial value that depends on itself

    What: the initial values of states depend on each other in a circle.
    Why: no order exists in which to compute them.
    Example: `state a = b; state b = a;`
    Way out: give one of the states an initial value that does not depend on the others.
    """
    return error(
        "BG532",
        f"the initial value of `{name}` depends on itself",
        span,
        help="give one of the states in the circle an independent initial value",
    )


def rate_not_linear(span: Span) -> Diagnostic:
    """BG533: an equation that is not linear in the rates

    What: an `equation` contains `der(x)` multiplied by a state or inside a function.
    Why: the equations have the form M der(x) = f, with M of constants and parameters.
    Example: `equation x*der(x) = 1;`
    Way out: declare the rate as an unknown: `unknown w; der(x) = w; equation x*w = 1;`
    """
    return error(
        "BG533",
        "this equation is not linear in the rates with constant coefficients",
        span,
        help="declare the rate as an unknown: `unknown w; der(x) = w;` and use `w` here",
    )
