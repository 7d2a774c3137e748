"""Diagnostics: causality and algebraic loops."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, listed, underlined, warning
from bgc.diagnostics.diagnostic import Fault, Label
from bgc.diagnostics.source import Span
from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class Connection:
    """An element on a path between others: its name, its kind (`J0`, `TF`, ..), its place."""

    name: str
    kind: str
    span: Span


@error(
    "BG501: `{one}` and `{other}` both set the same {what}",
    "remove one of them, or put an R or a C between them",
    note="they are connected through {path}",
)
def causal_conflict(
    first: Connection, second: Connection, what: str, between: Sequence[Connection]
) -> Values:
    labels = [Label(first.span, f"`{first.name}` sets {_set_by(first)} here")]
    variable = _set_by(first)
    for connection in between:
        if connection.kind == "GY":
            variable = "the flow" if variable == "the effort" else "the effort"
        labels.append(Label(connection.span, _passing(connection, variable)))
    labels.append(Label(second.span, f"`{second.name}` sets {_set_by(second)} too"))
    way = [first.name, *(connection.name for connection in between), second.name]
    return {
        "one": first.name,
        "other": second.name,
        "span": second.span,
        "path": " - ".join(_shortened(way)),
        "labels": underlined(labels),
    }


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


@error(
    "BG502: a closed chain of rigid connections through {through:listed}",
    "give all parts of it inertia, or make one of the connections compliant: use a C "
    "with an R in parallel",
    fault=Fault.CHOICE,
)
def rigid_chain(
    span: Span, transformers: Sequence[Connection], others: Sequence[Connection]
) -> Values:
    through = _names_of(transformers or others)
    labels = [Label(c.span, f"the modulus of `{c.name}` is in the chain") for c in transformers] + [
        Label(c.span, f"`{c.name}` is in the chain") for c in others
    ]
    return {
        "through": through,
        "note": (
            f"the chain also passes {listed(_names_of(others))}" if transformers and others else ""
        ),
        "labels": underlined(labels),
    }


def _names_of(connections: Sequence[Connection]) -> list[str]:
    """List the names once each: components of a wide element may share a name."""
    return list(dict.fromkeys(connection.name for connection in connections))


@error(
    "BG503: the modulus of `{name}` is zero",
    "give its parameters a value that makes it nonzero, or remove the element",
)
def zero_modulus(span: Span, name: str) -> None: ...
@warning(
    "BG504: {names:listed} constrain the same flow twice: their shares of the effort are "
    "undetermined",
    "remove one of the parallel connections",
)
def redundant_structure(span: Span, names: Sequence[str]) -> None: ...
@warning(
    "BG505: the bond `{name}` closes a loop of junctions: the flow or effort around it is "
    "undetermined",
    "remove the bond, or merge the junctions into one",
)
def bond_loop(span: Span, name: str) -> None: ...
@error(
    "BG506: nothing determines the {what} of `{name}`",
    "connect an element there, or do not observe the variable",
)
def nothing_determines(span: Span, name: str, what: str) -> None: ...
@warning(
    "BG507: nothing determines the {what} of `{name}`",
    "connect an element there, or remove the junction",
)
def indeterminate(span: Span, name: str, what: str) -> None: ...
@error(
    "BG508: `{name}` sets the {what} of a junction without a load",
    "connect an R, I or C to the junction",
)
def source_without_load(span: Span, name: str, what: str) -> None: ...
@error(
    "BG520: the algebraic loop through {bonds:listed} {which}",
    "break the loop with a storage element, or change the terms that cancel",
)
def singular_loop(
    span: Span,
    bonds: Sequence[str],
    elements: Sequence[str],
    solutions: str,
    places: Sequence[Label] = (),
) -> Values:
    return {
        "which": (
            {
                "none": "has no solution",
                "many": "has infinitely many solutions",
                "unclear": "has no solution or infinitely many",
            }[solutions]
        ),
        "note": f"the laws in the loop are those of {listed(elements)}" if elements else "",
        "labels": underlined(places),
    }


@error(
    "BG521: the reaction at {names:listed} depends on itself",
    "take the signal from another element, or put a C between them",
)
def derivative_loop(span: Span, names: Sequence[str]) -> None: ...
@error(
    "BG522: the reaction at `{name}` needs an unknown rate",
    "put a C with an R in parallel in between, or do not observe the variable",
    note="it is rigidly coupled to a device's input or to an unknown of an algebraic loop",
)
def rate_unknown(span: Span, name: str) -> None: ...
@error(
    "BG523: the odd loop of gyrators through {names} cannot be solved",
    "put an R, C or I into the loop, or remove one of the gyrators",
    note="it leaves {bonds:listed} undetermined",
)
def gyrator_loop(gyrators: Sequence[Connection], bonds: Sequence[str]) -> Values:
    first, *others = gyrators
    return {
        "names": listed([g.name for g in gyrators]),
        "span": first.span,
        "labels": [Label(g.span, f"`{g.name}` is in the loop") for g in others],
    }


@error(
    "BG524: the law of {elements:listed} cannot be inverted: it is {why}",
    "write the law with its sign, for example `f*abs(f)`, give it a small slope, or "
    "write it the other way round",
    note="it would have to give `{variable}`",
)
def not_invertible(span: Span, variable: str, elements: Sequence[str], why: str) -> None: ...
@error("BG531: the equations {fault}")
def singular_equations(
    span: Span, names: Sequence[str], solutions: str = "unclear", others: Sequence[Span] = ()
) -> Values:
    which = listed(names)
    fault, way_out = {
        "none": (
            f"for {which} have no solution: they contradict each other",
            "correct one of the equations; another factor or term makes it independent",
        ),
        "many": (
            f"for {which} repeat each other: infinitely many values satisfy them",
            "replace one of the equations by an independent one",
        ),
        "unclear": (
            f"do not determine {which}",
            "replace one of the equations by an independent one",
        ),
        "unpaired": (f"do not determine {which}", f"let one of the equations hold {which}"),
    }[solutions]
    labels = underlined(Label(other, "depends on this equation") for other in others)
    return {"fault": fault, "labels": labels, "help": way_out}


# BG531, of an equation that varies with no unknown: a constraint between states, usually.
# `constant_in` are unknowns that it holds, but does not vary with. `derivative` is its first
# derivative that holds an unknown, with its order.
@error(
    "BG531: the equations do not determine {names:listed}",
    note="this equation varies with no unknown and no rate that it could determine",
)
def equation_without_unknown(
    span: Span, names: Sequence[str], constant_in: Sequence[str], derivative: tuple[int, str] | None
) -> Values:
    if constant_in:
        return {
            "note": f"this equation is constant in {listed(constant_in)}, but for jumps",
            "help": "let it vary with its unknown: by a steep slope such as `tanh(z/0.01)` for "
            "`sign(z)`",
        }
    if derivative is None:
        return {
            "help": "let it hold an unknown; differentiate a constraint between states until it "
            "does: `x^2 + y^2 = l^2` becomes `x*vx + y*vy = 0`, whose derivative holds the force"
        }
    order, equation = derivative
    times = ("", "twice ", "three times ")[order - 1]
    lower = (
        "the constraint",
        "the constraint and its first derivative",
        "the constraint and its first two derivatives",
    )[order - 1]
    return {
        "help": f"differentiate it {times}in time: `equation {equation};`, and give the states "
        f"initial values that satisfy {lower}; or replace it by a stiff spring"
    }


@error(
    "BG532: the initial value of `{name}` depends on itself",
    "give one of the states in the circle an independent initial value",
)
def invalid_initial(span: Span | None, name: str) -> None: ...
@error(
    "BG533: this equation is not linear in the rates with constant coefficients",
    "declare the rate as an unknown: `unknown w; der(x) = w;` and use `w` here",
)
def rate_not_linear(span: Span) -> None: ...
