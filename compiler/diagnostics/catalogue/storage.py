"""Diagnostics of storage and its initial values."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, listed
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def variable_storage(span: Span, name: str, on: str) -> Diagnostic:
    """BG510: a storage law that depends on another variable

    What: the law of a C or I contains a variable other than its own charge or momentum and
    parameters.
    Why: that variable would bring in energy without a bond to account for it.
    Example: `C(stiffness = 3*other.q)`
    Way out: give the element a port for that variable: a C with two ports and an energy `H`, which
    gives the right effort on both.
    """
    return error(
        "BG510",
        f"the law of `{name}` depends on {on}",
        span,
        help="write it as a field with one port for each variable that its energy depends on",
    )


def storage_not_positive(span: Span, name: str, what: str) -> Diagnostic:
    """BG511: a storage element without a usable value

    What: the inertia or compliance of an element is zero, or its matrix is singular.
    Why: the flow or effort is computed by dividing by it.
    Example: `mass : I(0 kg);`
    Way out: give a positive value. Omit the C for a rigid connection and the I for a massless part.
    Give a singular stiffness matrix as `C(stiffness = K)`.
    """
    return error(
        "BG511", f"the {what} of `{name}` is zero or singular", span, help="make it positive"
    )


def dependent_storage(span: Span, name: str, others: Sequence[str], why: str) -> Diagnostic:
    """BG512: dependent storage that cannot be merged

    What: the stored energy of an element depends on that of others (derivative causality), and
    their common motion is undetermined: all moduli between them may become zero, or their
    stiffnesses cancel.
    Why: where the moduli are zero nothing holds the motion, and equations that divide by them are
    wrong without a warning. The compiler divides only by a modulus whose range excludes zero, such
    as `2 + sin(angle)`.
    Example: a massless lever that acts on springs only through modulated transformers.
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
    """BG513: a motion without inertia

    What: rigidly connected inertias have no common inertia along one of their motions. The mass
    matrix is singular, or so nearly singular that the accelerations would be noise: scaled to a
    unit diagonal, its smallest eigenvalue is below 1e-9.
    Why: a force along that motion would cause an infinite acceleration. A resistance could hold it,
    but its effect would vary with the moduli, so it is not considered.
    Example: a rigid arm with a massless last link; masses in the ratio 1e10 on rigid joints.
    Way out: give the moving part an inertia, or connect it by a compliance.
    """
    return error(
        "BG513",
        f"{listed(names)} can move without inertia",
        span,
        help="give the moving part an inertia, or connect it by a C",
    )


def initial_twice(span: Span, name: str, first: str, second: str) -> Diagnostic:
    """BG514: an initial value given twice

    What: a storage element is given two initial values for one port.
    Why: each of them determines the other.
    Example: `C(2 F, q0 = 1, e0 = 1)`
    Way out: remove one of them.
    """
    return error(
        "BG514", f"`{name}` is given both `{first}` and `{second}`", span, help="remove one of them"
    )


def initial_unusable(
    span: Span, name: str, variable: str, *, of_junction: bool = False
) -> Diagnostic:
    """BG515: an initial value that cannot be converted

    What: no state was found that gives the initial effort or flow.
    Why: the element's law does not reach the value, or the variable follows from rates of change
    instead of charges and momenta: the effort of an IC whose energy holds the momentum, or the
    flow of a J1 that only C determine, or a force that closes a chain of rigid connections.
    Example: `C(e0 = 3) { e = 2*tanh(q); }`
    Way out: give `q0` of a C or `p0` of an I, or a value that the law reaches.
    """
    if of_junction:
        return error(
            "BG515",
            f"`{variable}` of `{name}` does not follow from charges and momenta",
            span,
            help="omit it; it follows from how fast they change",
        )
    instead = {"e0": "give `q0` instead", "f0": "give `p0` instead"}
    return error(
        "BG515",
        f"the state of `{name}` cannot be computed from `{variable}`",
        span,
        help=instead.get(variable, "give the other variable of the element instead"),
    )


def initial_conflict(span: Span, name: str, variable: str, others: Sequence[str]) -> Diagnostic:
    """BG516: contradictory initial values

    What: an initial value differs from the one that follows from earlier values, from a source, or
    from the balance of the bonds, which may leave the element no freedom.
    Why: the elements are rigidly connected, so their values depend on each other.
    Example: two masses on one `J1` with different `f0`.
    Way out: give only one of them. A zero that is only the default of a part's parameter or input
    (such as `twist0` of a library body) is dropped without an error; `bgc causality` shows it.
    Beside a source: make the parameters of both agree at the start, or bond a resistor between the
    two, across which they may differ: a `Throttle` between a `Reservoir` and a `LumpedLine`.
    """
    against = f"the initial values of {listed(others)}" if others else "what drives or holds it"
    return error(
        "BG516",
        f"`{variable}` of `{name}` contradicts {against}",
        span,
        help="give only one of them; the other follows",
    )


def initial_against_source(
    span: Span, name: str, variable: str, source: str, place: Span, parameters: Sequence[str]
) -> Diagnostic:
    """Make BG516 for an initial value that a source contradicts; see `initial_conflict`."""
    what = "effort" if variable in ("q0", "e0") else "flow"
    by = f" by {listed(parameters, 4)}" if parameters else ""
    return error(
        "BG516",
        f"`{variable}` of `{name}` contradicts the source `{source}`, which gives its {what}",
        span,
        labels=[Label(place, f"gives the {what} of `{name}`, with nothing between them")],
        help=f"make the two agree at the start{by}, or bond a resistor between them, across which "
        "they may differ",
    )


def no_momentum(span: Span, name: str) -> Diagnostic:
    """BG518: a momentum that does not exist

    What: the momentum of a port of an IC is read, but the element's energy does not contain it.
    Why: such a port stores energy by its charge alone, like a C.
    Example: `plate : IC[2] { H = p[1]^2/2 + q[2]^2/(1 + q[1]); }` has no `plate.p[2]`, so `observe
    plate.p` fails.
    Way out: read only the existing components: `observe plate.p[1]`.
    """
    return error(
        "BG518",
        f"there is no `{name}`: the energy does not depend on it",
        span,
        help="omit it; that port stores energy by its charge `q` alone",
    )


def initial_out_of_reach(span: Span, name: str, variable: str) -> Diagnostic:
    """BG517: an initial value out of reach

    What: no state of the model was found at which the initial value holds.
    Why: the element is rigidly connected to others, and their laws together do not reach the value;
    or Newton's method does not find the state.
    Example: `f0 = 3` of a coil in series with one whose law `f = 2*tanh(p)` stays below 2.
    Way out: give a value within the range of the laws, or give the charges and momenta instead.
    """
    return error(
        "BG517",
        f"no state was found at which `{variable}` of `{name}` has its value",
        span,
        note="the element is rigidly connected to others, and not all laws are linear",
        help="give a value that the laws reach, or give `q0` and `p0` instead",
    )
