"""Diagnostics of storage and its initial values."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, listed
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


def variable_storage(span: Span, name: str, on: str) -> Diagnostic:
    """BG510: a storage law that depends on something else

    What: the law of a C or I holds a variable other than its own charge or momentum and
    parameters.
    Why: energy would come in by that variable without a bond to account for it.
    Example: `C(stiffness = 3*other.q)`
    Way out: give the element a port for that variable: a C of two ports with an energy
    `H`, which yields the right effort on both.
    """
    return error(
        "BG510",
        f"the law of `{name}` depends on {on}",
        span,
        help="write it as a field with one port for each variable its energy depends on",
    )


def storage_not_positive(span: Span, name: str, what: str) -> Diagnostic:
    """BG511: a storage element without a usable value

    What: the inertia or compliance of an element is zero, or its matrix is singular.
    Why: its flow or effort is found by dividing by it.
    Example: `mass : I(0 kg);`
    Way out: give a positive value; for a rigid connection leave the C out, for a massless
    part leave the I out, or give a singular stiffness matrix as `C(stiffness = K)`.
    """
    return error(
        "BG511", f"the {what} of `{name}` is zero or singular", span, help="make it positive"
    )


def dependent_storage(span: Span, name: str, others: Sequence[str], why: str) -> Diagnostic:
    """BG512: dependent storage that cannot be merged

    What: an element's stored energy is not independent of others (derivative causality), and
    what joins them does not tell how they move: all moduli between them may vanish, or their
    stiffnesses cancel.
    Why: where the moduli vanish nothing holds the motion, and equations that divide by them are
    wrong there without a sign.
    Example: a lever without mass that acts on springs by modulated transformers only.
    Way out: put an I on the motion, or an R or a C that acts on it directly.
    """
    depends = f"depends on {listed(others)}" if others else "is not independent"
    return error(
        "BG512",
        f"the storage of `{name}` {depends}, and {why}",
        span,
        help="put an I on the motion that joins them, or an R or a C that acts on it directly",
    )


def motion_without_inertia(span: Span, names: Sequence[str]) -> Diagnostic:
    """BG513: a motion that nothing with inertia takes part in

    What: inertias that rigid connections make one have no common inertia along one of their
    motions: the mass matrix of the mechanism is singular, or so nearly that the accelerations
    would be noise (scaled to a diagonal of ones, its least eigenvalue is below 1e-9).
    Why: a force along that motion would give an infinite acceleration. A resistance along it
    could hold it, but how would change with the moduli that lead there, so it is not asked.
    Example: a rigid arm whose last link has the mass 0; masses in the ratio 1e10 on rigid joints.
    Way out: give what moves an inertia of its own, or join it by a compliance.
    """
    return error(
        "BG513",
        f"{listed(names)} can move without inertia",
        span,
        help="give what moves an inertia of its own, or join it by a C",
    )


def initial_twice(span: Span, name: str, first: str, second: str) -> Diagnostic:
    """BG514: an initial value given twice

    What: a storage element is given two initial values for one port.
    Why: either one fixes the other.
    Example: `C(2 F, q0 = 1, e0 = 1)`
    Way out: remove one of them.
    """
    return error(
        "BG514", f"`{name}` is given both `{first}` and `{second}`", span, help="remove one of them"
    )


def initial_unusable(span: Span, name: str, variable: str) -> Diagnostic:
    """BG515: an initial value that cannot be converted

    What: the state that belongs to an initial effort or flow could not be found.
    Why: the element's law could not be solved for its charge or momentum.
    Example: `e0` of a C whose law is a table of conditions.
    Way out: give `q0` of a C, `p0` of an I; of several that are joined rigidly, all or none.
    """
    instead = {"e0": "give `q0` instead", "f0": "give `p0` instead"}
    return error(
        "BG515",
        f"the state of `{name}` cannot be found from `{variable}`",
        span,
        help=instead.get(variable, "give the values of all that it is joined to rigidly, or none"),
    )


def initial_conflict(span: Span, name: str, variable: str, others: Sequence[str]) -> Diagnostic:
    """BG516: initial values that contradict each other

    What: an initial value differs from the one that follows from others, given before it, or
    from what a source prescribes.
    Why: the elements are joined rigidly, so their values are not independent.
    Example: two masses on one `J1` with different `f0`.
    Way out: give one of them only. A zero that is nothing but the default of a part's parameter
    or input (the `twist0` of a library's body) contradicts nothing: it gives way, as
    `bgc causality` tells.
    """
    against = f"the initial values of {listed(others)}" if others else "the source that drives it"
    return error(
        "BG516",
        f"`{variable}` of `{name}` contradicts {against}",
        span,
        help="give only one of them; the other follows",
    )


def no_momentum(span: Span, name: str) -> Diagnostic:
    """BG518: a momentum that is not there

    What: the momentum of a port of an IC is asked for, and its energy does not hold it.
    Why: such a port stores by its charge alone, as that of a C does.
    Example: `plate : IC[2] { H = p[1]^2/2 + q[2]^2/(1 + q[1]); }` has no `plate.p[2]`, so
    `observe plate.p` cannot be answered.
    Way out: ask for the components that there are: `observe plate.p[1]`.
    """
    return error(
        "BG518",
        f"there is no `{name}`: the energy does not hold it",
        span,
        help="leave it out; that port stores by its charge `q` alone",
    )


def initial_incomplete(span: Span, name: str, others: Sequence[str]) -> Diagnostic:
    """BG517: initial values of which some are missing

    What: storage elements that are joined rigidly, not all with a linear law, are given some
    initial values but not all.
    Why: where all laws are linear the missing values are those of the least energy; for other
    laws they are not guessed.
    Example: two C with laws of their own side by side on a `J0`, one with `q0`, one without.
    Way out: give the charge (`q0`) or momentum (`p0`) of each; with none given all are zero.
    """
    return error(
        "BG517",
        f"the initial value of `{name}` is not enough: {listed(others)} cannot be found from it",
        span,
        note="they are joined rigidly, and their laws are not all linear",
        help="give `q0` (or `p0`) of each of them",
    )
