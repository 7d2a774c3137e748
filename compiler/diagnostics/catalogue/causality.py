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
    """BG501: two sources prescribe the same variable"""
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
    """BG502: a closed chain of rigid connections"""
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
    """BG503: a modulus that is zero"""
    return error(
        "BG503",
        f"the modulus of `{name}` is zero",
        span,
        help="give its parameters a value that makes it nonzero, or remove the element",
    )


def redundant_structure(span: Span, names: Sequence[str]) -> Diagnostic:
    """BG504: a redundant connection"""
    return warning(
        "BG504",
        f"{listed(names)} constrain the same flow twice: their shares of the effort are "
        "undetermined",
        span,
        help="remove one of the parallel connections",
    )


def bond_loop(span: Span, name: str) -> Diagnostic:
    """BG505: a loop of bonds between junctions"""
    return warning(
        "BG505",
        f"the bond `{name}` closes a loop of junctions: the flow or effort around it is "
        "undetermined",
        span,
        help="remove the bond, or merge the junctions into one",
    )


def nothing_determines(span: Span, name: str, what: str) -> Diagnostic:
    """BG506: a variable that nothing determines"""
    return error(
        "BG506",
        f"nothing determines the {what} of `{name}`",
        span,
        help="connect an element there, or do not observe the variable",
    )


def indeterminate(span: Span, name: str, what: str) -> Diagnostic:
    """BG507: a part of the graph without an element"""
    return warning(
        "BG507",
        f"nothing determines the {what} of `{name}`",
        span,
        help="connect an element there, or remove the junction",
    )


def source_without_load(span: Span, name: str, what: str) -> Diagnostic:
    """BG508: a source without a load"""
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
    """BG520: an algebraic loop without a unique solution"""
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
    """BG521: a loop through the rate of a dependent variable"""
    return error(
        "BG521",
        f"the reaction at {listed(names)} depends on itself",
        span,
        help="take the signal from another element, or put a C between them",
    )


def rate_unknown(span: Span, name: str) -> Diagnostic:
    """BG522: an unknown rate"""
    return error(
        "BG522",
        f"the reaction at `{name}` needs an unknown rate",
        span,
        note="it is rigidly coupled to a device's input or to an unknown of an algebraic loop",
        help="put a C with an R in parallel in between, or do not observe the variable",
    )


def gyrator_loop(gyrators: Sequence[Connection], bonds: Sequence[str]) -> Diagnostic:
    """BG523: an odd loop of gyrators that cannot be solved"""
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
    """BG524: a law that cannot be inverted"""
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
    """BG531: equations that do not determine their unknowns"""
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
    """BG532: an initial value that depends on itself"""
    return error(
        "BG532",
        f"the initial value of `{name}` depends on itself",
        span,
        help="give one of the states in the circle an independent initial value",
    )


def rate_not_linear(span: Span) -> Diagnostic:
    """BG533: an equation that is not linear in the rates"""
    return error(
        "BG533",
        "this equation is not linear in the rates with constant coefficients",
        span,
        help="declare the rate as an unknown: `unknown w; der(x) = w;` and use `w` here",
    )
