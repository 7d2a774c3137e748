"""Diagnostics of elements' laws, initial values, states and equations."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, with_article
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def law_of_model(span: Span, name: str) -> Diagnostic:
    """BG430: a law block on a model

    What: a part has a law in braces, but its type is a model.

    Why: only basic elements have a law; a model takes arguments.

    Example: `boom : Beam { e = 2*f; }`

    Way out: give arguments, `boom : Beam(..);`, or extend the model: `model B is Beam { .. }`.
    """
    return error(
        "BG430",
        f"`{name}` is a model and takes no law",
        span,
        help="give it arguments, or extend it with `model .. is`",
    )


def law_missing(span: Span, name: str, kind: str, way: str) -> Diagnostic:
    """BG431: an element without a law

    What: an element has neither an argument nor a law block.

    Why: the relation between its variables is then unknown.

    Example: `coil : I;`

    Way out: give it an argument, `coil : I(2 mH);`, or a law, `spring : C { e = k*q^3; }`.
    """
    return error("BG431", f"`{name}`, {with_article(kind)}, has no law", span, help=way)


def law_and_argument(span: Span, name: str, argument: str, other: str = "a law") -> Diagnostic:
    """BG432: an element with two laws

    What: an element has an argument that is its law, and also a law in braces or another such
    argument.

    Why: the element would have two laws.

    Example: `r : R(2 ohm) { e = 3*f; }`

    Way out: remove one.
    """
    return error(
        "BG432",
        f"`{name}` has both the argument `{argument}` and {other}",
        span,
        help="remove one of them",
    )


def law_not_of_this(span: Span, kind: str, left: str, have: Sequence[str]) -> Diagnostic:
    """BG433: a law for a variable that the element does not have

    What: the left side of a law is not a variable that defines this kind of element.

    Why: a C relates `e` and `q`, an I `f` and `p`, an R `e` and `f`, a TF or GY the two sides.

    Example: `spring : C { f = 2*p; }`

    Way out: write one of the forms that the help lists.
    """
    listing = " or ".join(f"`{h}`" for h in have)
    return error(
        "BG433", f"a law of {kind} cannot start with `{left}`", span, help=f"write {listing}"
    )


def flows_not_invertible(span: Span, name: str, why: str) -> Diagnostic:
    """BG447: a gyrator given by flows that cannot be inverted

    What: the law of a GY or MGY gives flows, `f1 = g*e2` or `f2 = g*e1`, and its matrix is not
    known to have an inverse.

    Why: a gyrator is defined by its ratio r, `e1 = r' f2` and `e2 = r f1`; a law of flows is the
    inverse. A number or a matrix of constants and parameters is inverted; a varying matrix might
    become singular during the run.

    Example: `pump : GY { f1 = [[1, 2], [2, 4]]*e2; }`

    Way out: give efforts instead: `e2 = r*f1` or `e1 = r*f2`.
    """
    return error(
        "BG447",
        f"the ratio of `{name}` cannot be computed from its flows: {why}",
        span,
        help="give efforts instead: `e2 = r*f1` or `e1 = r*f2`",
    )


def law_variable_misplaced(span: Span, kind: str, left: str, found: str, right: str) -> Diagnostic:
    """BG434: a law in terms of the wrong variable

    What: the right side of a law contains a variable that this law cannot depend on.

    Why: `e = ..` of a C is a function of `q`, `f = ..` of an I is a function of `p`, and `e2 = ..`
    is a function of `e1` for a TF and of `f1` for a GY.

    Example: `spring : C { e = k*f; }`

    Way out: use the variable that the message names.
    """
    return error(
        "BG434",
        f"`{left} = ..` of {kind} must depend on `{right}`, not on `{found}`",
        span,
        help=f"write it in terms of `{right}`",
    )


def law_variable_is_a_name(span: Span, name: str) -> Diagnostic:
    """BG435: a name that means two things in a law

    What: a law names a variable of its element, and the model also declares a value of that name.

    Why: in a law the names `e f p q` (for a two-port `e1 f1 e2 f2`) are variables of the element.

    Example: `param f = 50 Hz; drag : R { e = 2*f; }`

    Way out: rename the value.
    """
    return error(
        "BG435",
        f"`{name}` is a variable of the element and also a value of this model",
        span,
        help=f"rename the value `{name}`",
    )


def law_not_linear(span: Span, name: str, right: str) -> Diagnostic:
    """BG436: a law that is not linear where it must be

    What: a law of a TF or GY is not a matrix times its variable, or a C or I is given by a
    nonlinear `q = ..` or `p = ..`.

    Why: the dual law of a two-port is derived with the transposed matrix, so that power is
    conserved; this needs a linear law. A C or I given by `q = ..` or `p = ..` would have to be
    inverted.

    Example: `map : MTF { f2 = f1^2; }`

    Way out: write `matrix*variable`, where the matrix may depend on states. For storage write `e =
    ..` as a function of `q` (`f = ..` of `p`), or the energy `H = ..`.
    """
    return error(
        "BG436",
        f"the law of `{name}` is not linear in `{right}`",
        span,
        help=f"write it as a factor or matrix times `{right}`; give nonlinear storage by its "
        "energy `H = ..`",
    )


def law_incomplete(
    span: Span, name: str, left: str, width: int, component: int, repeated: bool = False
) -> Diagnostic:
    """BG437: a law with missing or repeated components

    What: a law written component by component omits one or gives one twice.

    Why: each component of the element needs exactly one equation.

    Example: `field : C[2] { e[1] = q[1]; }`

    Way out: write one equation for each component, or one vector equation.
    """
    verb = "repeats" if repeated else "omits"
    return error(
        "BG437",
        f"the law of `{name}` {verb} `{left}[{component}]`, one of its {width} components",
        span,
        help="write one equation for each component, or one for the whole vector",
    )


def law_too_many(span: Span, name: str, needed: str) -> Diagnostic:
    """BG438: more equations than a law has

    What: a law block contains more equations than the element needs.

    Why: one equation is the law of a one-port; the dual law of a two-port follows from the first.

    Example: `r : R { e = 2*f; f = e/2; }`

    Way out: keep one. A TF may give both directions of a rotation: `f2 = ..` and `f1 = ..`.
    """
    return error("BG438", f"the law of `{name}` has too many equations", span, help=needed)


def wrong_matrix(span: Span, what: str, expected: str, found: str) -> Diagnostic:
    """BG439: a law's matrix of the wrong size

    What: a value given to an element does not match its width.

    Why: an element of width n has n components of effort and flow.

    Example: `field : C[2](stiffness = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]);`

    Way out: give a scalar (the same for all components), a vector (one value for each), or an n x n
    matrix.
    """
    return error(
        "BG439",
        f"{what} must be {expected}, not {found}",
        span,
        help="give a scalar, a vector with one value for each component, or a matrix",
    )


def modulated(span: Span, name: str, kind: str) -> Diagnostic:
    """BG440: a modulated element without the `M`

    What: the law of a TF, GY or R depends on time, a state or a signal.

    Why: such an element is modulated, and the `M` in its name shows this to the reader.

    Example: `lever : TF(ratio = cos(angle));`

    Way out: write MTF, MGY or MR.
    """
    return error(
        "BG440",
        f"`{name}` varies during the run, so it must be a modulated element",
        span,
        help=f"write `M{kind}` instead of `{kind}`",
    )


def storage_varies(span: Span, name: str, kind: str) -> Diagnostic:
    """BG441: a storage element with a varying law

    What: the law of a C or I depends on time, or on a variable other than its own state.

    Why: its energy would change without power through a bond.

    Example: `spring : C(stiffness = 2 + time);`

    Way out: use constants and parameters. If the energy depends on several states, use one element
    with several ports and an energy law `H = ..`, or put an MTF before the element.
    """
    return error(
        "BG441",
        f"the law of `{name}`, {with_article(kind)}, depends on something other than its own state",
        span,
        help="use constants and parameters, an energy law, or an MTF before it",
    )


def not_skew(span: Span, name: str, row: int, column: int) -> Diagnostic:
    """BG442: a one-sided gyrator that is not skew

    What: the matrix of an MGY with all its bonds on one side (eq. 13 of the paper) is not
    skew-symmetric: `S[i, j]` is not `-S[j, i]`.

    Why: only a skew-symmetric matrix conserves power.

    Example: `gyro : MGY[3] { e = [[0, 1, 0], [1, 0, 0], [0, 0, 0]]*f; }`

    Way out: correct the matrix; use an R to dissipate power.
    """
    return error(
        "BG442",
        f"the matrix of `{name}` is not skew: entry [{row}, {column}] is not the opposite of "
        f"[{column}, {row}]",
        span,
        help="correct the matrix; use an R to dissipate power",
    )


def one_sided(span: Span, name: str, kind: str, missing: str) -> Diagnostic:
    """BG443: a two-port with bonds on one side only

    What: a TF or GY has no bond on one of its sides.

    Why: power passes from the incoming bond to the outgoing one.

    Example: `a -> gear;`

    Way out: bond the other side. Only an MGY with a skew matrix may have all its bonds on one side.
    """
    return error(
        "BG443",
        f"`{name}`, {with_article(kind)}, has no bond {missing} it",
        span,
        help="write `.. -> name -> ..`",
    )


def inverse_differs(span: Span, name: str) -> Diagnostic:
    """BG444: two laws of a transformer that contradict each other

    What: both directions of a TF are given, and the matrices are not inverse to each other.

    Why: `f2 = m f1` and `f1 = w f2` agree only if `w m` is the identity.

    Example: `turn : MTF { f2 = transpose(B)*f1; f1 = 2*B*f2; }`

    Way out: correct one, or remove one.
    """
    return error(
        "BG444",
        f"the two equations of `{name}` are not inverse to each other",
        span,
        help="correct one, or remove one",
    )


def initial_not_of_this(span: Span, name: str, kind: str, have: Sequence[str]) -> Diagnostic:
    """BG446: an initial value that the element does not take

    What: `p0` is given to a C, `q0` to an I, or an initial value to an element that stores nothing.

    Why: a C starts from its displacement `q0` or effort `e0`, an I from its momentum `p0` or
    flow `f0`.

    Example: `coil : I(L, q0 = 1);`

    Way out: use one of the names that the help lists.
    """
    listing = " or ".join(f"`{h}`" for h in have)
    return error(
        "BG446",
        f"`{name}` is not an initial value of {kind}",
        span,
        help=f"give {listing}" if have else "remove it: this element stores nothing",
    )


def not_a_state(span: Span, name: str) -> Diagnostic:
    """BG450: the derivative of a value that is not a state

    What: `der(x) = ..;` or `project x = ..;` is written for something other than a `state` of this
    model.

    Why: only a declared state is integrated.

    Example: `let x = 0; der(x) = 1;`

    Way out: declare it: `state x = 0;` (`project` of a whole signal is allowed too).
    """
    return error(
        "BG450",
        f"`{name}` is not a state of this model",
        span,
        help=f"declare it: `state {name} = ..;`",
    )


def state_without_equation(span: Span, name: str) -> Diagnostic:
    """BG451: a state without an equation

    What: a `state` has no `der(x) = ..;`, no `equation` contains `der(x)`, and no equation is left
    to determine `x` itself.

    Why: its rate of change is unknown.

    Example: `state x = 1;` without an equation.

    Way out: write `der(x) = ..;`. Declare a value that depends only on others as a `signal`, and a
    value that follows from an `equation` as an `unknown`.
    """
    return error(
        "BG451",
        f"the state `{name}` has no equation for its rate",
        span,
        help=f"write `der({name}) = ..;`",
    )


def equations_and_unknowns(span: Span, equations: int, unknowns: int) -> Diagnostic:
    """BG452: unequal numbers of equations and unknowns

    What: the model has more or fewer scalar `equation`s than `unknown`s and states without a
    `der(x) = ..;`.

    Why: each unknown needs one equation.

    Example: `unknown z = 0;` without an `equation`.

    Way out: add or remove an equation; a vector equation counts once for each component.
    """
    return error(
        "BG452",
        f"{_counted(equations, 'equation')} for {_counted(unknowns, 'unknown')}",
        span,
        help="give each `unknown`, and each state without `der(x) = ..;`, one equation",
    )


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def law_of_junction(span: Span, name: str, kind: str) -> Diagnostic:
    """BG455: a junction with a law

    What: a J0, J1 or Mux has a law block.

    Why: the law of a junction is fixed: its bonds share the effort (J0) or the flow (J1).

    Example: `node : J1 { e = 2*f; }`

    Way out: put the law on an element that is bonded to it.
    """
    return error(
        "BG455",
        f"`{name}` is {with_article(kind)} and takes no law",
        span,
        help="put the law on an element that is bonded to it",
    )


def false_assert(span: Span, message: str, place: Span) -> Diagnostic:
    """BG456: an `assert` that the constants of a part break

    What: the condition of an `assert` depends on constants only, and it is false.

    Why: the model holds only where its asserts do. What depends on parameters or states is checked
    when the model runs (BG705); what is constant is checked when it is compiled.

    Example: `joint : Revolute(axis = [0, -2, 0]);` where the model has
    `assert is_unit(axis), "the axis has to be a unit vector";`

    Way out: give other constants to the part.
    """
    return error(
        "BG456",
        message,
        span,
        labels=[Label(place, "asserted here")],
        help="give other constants to the part",
    )
