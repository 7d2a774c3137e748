"""Diagnostics of causality and algebraic loops."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from bgc.diagnostics.catalogue import error, listed, underlined, warning
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


@dataclass(frozen=True, slots=True)
class Connection:
    """An element on the way between others: its name, its kind (`J0`, `TF`, ..), its place."""

    name: str
    kind: str
    span: Span


def causal_conflict(
    first: Connection, second: Connection, what: str, between: Sequence[Connection]
) -> Diagnostic:
    """BG501: two sources prescribe the same variable

    What: two sources both set one flow, or both set one effort, along a rigid path of
    junctions and transformers.
    Why: each would impose its own value; unless they agree for ever there is no solution, and
    if they do, what each contributes cannot be told.
    Example: two `Se` on one `J0`.
    Way out: remove one of them, or put an element between them that can give way: an R
    (the inner resistance of a source) or a C.
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
        note=f"they meet along {' - '.join(_shortened(way))}",
        labels=underlined(labels),
        help="remove one of them, or put an R or a C between them",
    )


def _set_by(source: Connection) -> str:
    return "the effort" if source.kind == "Se" else "the flow"


def _passing(connection: Connection, variable: str) -> str:
    """What a rigid connection does to the variable on its way."""
    match connection.kind, variable:
        case ("J0", "the effort") | ("J1", "the flow"):
            return f"`{connection.name}` has one {variable[4:]}"
        case (("J0" | "J1"), _):
            return f"{variable}s add up at `{connection.name}`"
        case "GY", _:
            return f"`{connection.name}` makes {variable} of it"
        case _:
            return f"`{connection.name}` passes {variable} on"


def _shortened(way: Sequence[str], most: int = 9) -> list[str]:
    """A long way without its middle."""
    if len(way) <= most:
        return list(way)
    half = most // 2
    return [*way[:half], f"({len(way) - 2 * half} more)", *way[-half:]]


def rigid_chain(
    span: Span, transformers: Sequence[Connection], others: Sequence[Connection]
) -> Diagnostic:
    """BG502: a closed chain of rigid connections

    What: junctions and transformers close a chain whose flows could only be found by dividing
    by a modulus that depends on the state, and so may vanish during the run.
    Why: at the position where the modulus is zero the chain locks or loses its drive; equations
    that divide by it are wrong there without a sign.
    Example: a four-bar linkage all of whose joints are rigid.
    Way out: make one connection compliant: a C (with an R in parallel) at one of the joints.
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
        help="make one of its connections compliant: a C with an R in parallel",
    )


def _names_of(connections: Sequence[Connection]) -> list[str]:
    """Their names, each once: components of a wide element may share one."""
    return list(dict.fromkeys(connection.name for connection in connections))


def zero_modulus(span: Span, name: str) -> Diagnostic:
    """BG503: a modulus that is zero

    What: the flows around a transformer or gyrator can only be found by dividing by its
    modulus, which is zero at the given value of its parameters.
    Why: a connection with modulus zero carries nothing over.
    Example: `param n = 0; gear : TF(n);`
    Way out: give the parameter a value other than zero, or leave the element out.
    """
    return error(
        "BG503",
        f"the modulus of `{name}` is zero",
        span,
        help="give its parameters a value that makes it nonzero, or leave the element out",
    )


def redundant_structure(span: Span, names: Sequence[str]) -> Diagnostic:
    """BG504: a connection that is there twice

    What: what a junction or transformer demands of the flows already follows from others.
    Why: how the parallel connections share the effort between them is not determined.
    Example: two `J0` joined by two bonds.
    Way out: remove one of the parallel connections. If only one of their efforts matters to
    nobody, nothing needs to be done.
    """
    return warning(
        "BG504",
        f"{listed(names)} demand the same twice: how they share the effort is not determined",
        span,
        help="remove one of the parallel connections",
    )


def bond_loop(span: Span, name: str) -> Diagnostic:
    """BG505: a loop of bonds between junctions

    What: a bond closes a loop of junctions of one kind.
    Why: any amount could circulate in the loop without an effect elsewhere.
    Example: two `J1` joined by two bonds.
    Way out: remove the bond.
    """
    return warning(
        "BG505",
        f"the bond `{name}` closes a loop of junctions: what circulates in it is not determined",
        span,
        help="remove the bond, or make one junction of it",
    )


def nothing_determines(span: Span, name: str, what: str) -> Diagnostic:
    """BG506: a variable that nothing determines

    What: a flow or an effort is asked for, or needed, that the model leaves open.
    Why: no element at these bonds stores, dissipates or drives it, or it may circulate.
    Example: the flow of a `J1` whose two bonds lead to the same `J0`.
    Way out: connect an element to the junction, or do not observe the variable.
    """
    return error(
        "BG506",
        f"nothing determines the {what} of `{name}`",
        span,
        help="connect an element there, or do not ask for it",
    )


def indeterminate(span: Span, name: str, what: str) -> Diagnostic:
    """BG507: a part of the graph without an element

    What: no element at these bonds stores, dissipates or drives anything.
    Why: what flows there is not determined; it has no effect elsewhere.
    Example: two junctions joined to nothing but each other.
    Way out: connect an element, or remove the junctions.
    """
    return warning(
        "BG507",
        f"nothing determines the {what} of `{name}`",
        span,
        help="connect an element there, or remove it",
    )


def source_without_load(span: Span, name: str, what: str) -> Diagnostic:
    """BG508: a source that nothing answers to

    What: a source sets the effort of junctions without any other element, or the flow into
    them.
    Why: a source of effort on nothing but a junction of common flow is a short circuit, a
    source of flow on nothing but a junction of common effort has no way out.
    Example: `supply : Se(e = 5 V); loop : J1; supply -> loop;`
    Way out: connect the element that should answer: an R, I or C.
    """
    return error(
        "BG508",
        f"nothing answers to the {what} that `{name}` sets",
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
    """BG520: an algebraic loop without a single solution

    What: variables depend on each other in a circle, and the equations of the circle have no
    solution, or infinitely many; the message says which where that can be told.
    Why: the loop adds up to nothing, for example a feedback of exactly one. What is left of its
    equations then is either a contradiction or says nothing.
    Example: `MSe(e = junction.f * R)` that cancels a resistance R. With a capacitor on the same
    junction no flow balances it; with nothing else there any flow does.
    Way out: break the loop with a storage element, or change the values in it.
    """
    which = {
        "none": "has no solution",
        "many": "has infinitely many solutions",
        "unclear": "has no solution or infinitely many",
    }[solutions]
    note = f"its laws are those of {listed(elements)}" if elements else ""
    return error(
        "BG520",
        f"the algebraic loop through {listed(bonds)} {which}",
        span,
        note=note,
        labels=underlined(places),
        help="break it with a storage element, or remove what cancels in it",
    )


def derivative_loop(span: Span, names: Sequence[str]) -> Diagnostic:
    """BG521: a loop through the rate of a dependent variable

    What: the effort of a dependent inertia (or the flow of a dependent compliance) decides on
    the rate that it is computed from.
    Why: that effort is known only after the rates of all states are.
    Example: a source whose effort follows the inertia force of a rigidly driven mass.
    Way out: observe the effort at another element, or put a C between the source and the mass.
    """
    return error(
        "BG521",
        f"the reaction at {listed(names)} depends on itself",
        span,
        help="take the signal from another element, or put a C between them",
    )


def rate_unknown(span: Span, name: str) -> Diagnostic:
    """BG522: a rate that is not known

    What: an effort or flow is needed that depends on how fast a device's input, or the
    unknown of an algebraic loop, changes.
    Why: a sampled input has no rate, and that of a loop's unknown is not computed.
    Example: the force of an `Sf` driven by a device on a rigid mass.
    Way out: do not ask for the variable (nor for the energy supplied), or put a virtual
    coupling (a C with an R in parallel) behind the device.
    """
    return error(
        "BG522",
        f"the reaction at `{name}` needs a rate that is not known",
        span,
        note="it follows a device's input, or the unknown of an algebraic loop, rigidly",
        help="put a C with an R in parallel in between, or do not ask for the variable",
    )


def gyrator_loop(gyrators: Sequence[Connection], bonds: Sequence[str]) -> Diagnostic:
    """BG523: an odd loop of gyrators that leaves a flow open

    What: a loop with an odd number of gyrators leaves a direction of flow on which the gyrators
    have no say, and no storage element or resistance decides on it either; or it could only be
    found by dividing by moduli that may vanish.
    Why: the balance on that flow is a condition on sources alone, which holds never or always.
    (With storage in the loop it is a condition on what is stored, which is merged.)
    Example: three gyrators in a ring between three junctions with nothing but an `Se` each.
    Way out: put an R, C or I into the loop, which every real one has, or leave a gyrator out.
    """
    first, *others = gyrators
    return error(
        "BG523",
        f"the odd loop of gyrators through {listed([g.name for g in gyrators])} cannot be solved",
        first.span,
        labels=[Label(g.span, f"`{g.name}` is in the loop") for g in others],
        note=f"it leaves {listed(bonds)} undetermined",
        help="put an R, C or I into the loop, or leave one of the gyrators out",
    )


def not_invertible(span: Span, variable: str, elements: Sequence[str], why: str) -> Diagnostic:
    """BG524: a law that cannot be turned round

    What: the graph gives the variable that a law computes, and asks for the one that it is
    computed from; but the law is the same for a value and its opposite, or for a whole range.
    Why: there are then two or infinitely many answers, and no reason to take one of them.
    Example: `R { e = k*f^2; }` on a junction whose effort a source sets, or a valve that is
    closed for a range of efforts on one whose flow a source sets.
    Way out: write the law with its sign (`k*f*abs(f)`), with a small leak where it is flat, or
    the other way round (`f = ...` instead of `e = ...`).
    """
    return error(
        "BG524",
        f"the law of {listed(elements)} cannot be turned round: it is {why}",
        span,
        note=f"`{variable}` is asked for",
        help="write it with its sign, as `f*abs(f)`, give it a small slope, or write it the"
        " other way round",
    )


def singular_equations(span: Span, names: Sequence[str]) -> Diagnostic:
    """BG531: equations that do not determine their unknowns

    What: an equation holds none of the unknowns and rates that are left for it.
    Why: some unknown then stays open, and some equation contradicts or repeats others.
    Example: `unknown a; unknown b; equation a = 1; equation 2*a = 3;`
    Way out: check which equation is meant for which unknown. A constraint between states alone, as
    `x^2 + y^2 = 1` for the force in a rod, does not hold what it determines: differentiate it
    until it does (index 1), or make the constraint a stiff spring.
    """
    return error(
        "BG531",
        f"the equations do not determine {listed(names)}",
        span,
        help="check which equation is meant for which unknown; differentiate a constraint between "
        "states until it holds one",
    )


def invalid_initial(span: Span | None, name: str) -> Diagnostic:
    """BG532: an initial value that depends on itself

    What: the initial values of states depend on each other in a circle.
    Why: none of them can be computed first.
    Example: `state a = b; state b = a;`
    Way out: give one of them a value of its own.
    """
    return error(
        "BG532",
        f"the initial value of `{name}` depends on itself",
        span,
        help="give one of the states in the circle a value of its own",
    )


def rate_not_linear(span: Span) -> Diagnostic:
    """BG533: an equation that is not linear in the rates

    What: an `equation` holds a `der(x)` in a product with a state, or inside a function.
    Why: the rates enter by a mass matrix of constants and parameters.
    Example: `equation x*der(x) = 1;`
    Way out: declare the rate as an unknown: `unknown w; der(x) = w; equation x*w = 1;`
    """
    return error(
        "BG533",
        "this equation is not linear in the rates with constant coefficients",
        span,
        help="declare the rate as an unknown: `unknown w; der(x) = w;` and use `w` here",
    )
