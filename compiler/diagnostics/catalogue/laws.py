"""Diagnostics of elements' laws, initial values, states and equations."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, with_article
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span


def law_of_model(span: Span, name: str) -> Diagnostic:
    """BG430: a law block on a model

    What: a part whose type is a model has a law in braces.

    Why: only basic elements have a law; a model is given arguments.

    Example: `boom : Beam { e = 2*f; }`

    Way out: give arguments, `boom : Beam(..);`, or extend the model: `model B is Beam { .. }`.
    """
    return error(
        "BG430",
        f"`{name}` is a model, and takes no law",
        span,
        help="give it arguments, or extend it by `model .. is`",
    )


def law_missing(span: Span, name: str, kind: str, way: str) -> Diagnostic:
    """BG431: an element without a law

    What: an element has neither an argument nor a law block.

    Why: what it does is not known.

    Example: `coil : I;`

    Way out: give it an argument, `coil : I(2 mH);`, or a law, `spring : C { e = k*q^3; }`.
    """
    return error("BG431", f"`{name}` has no law: what does this {kind} do?", span, help=way)


def law_and_argument(span: Span, name: str, argument: str, other: str = "a law") -> Diagnostic:
    """BG432: an element with two laws

    What: an element has an argument that is its law, and a law in braces or another such argument
    too.

    Why: which of them holds could not be told.

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

    What: the left side of a law is not one that this kind of element is defined by.

    Why: a C relates `e` and `q`, an I `f` and `p`, an R `e` and `f`, a TF or GY the two sides.

    Example: `spring : C { f = 2*p; }`

    Way out: write one of the forms that the message lists.
    """
    listing = " or ".join(f"`{h}`" for h in have)
    return error(
        "BG433", f"a law of {kind} cannot start with `{left}`", span, help=f"write {listing}"
    )


def flows_not_invertible(span: Span, name: str, why: str) -> Diagnostic:
    """BG447: a gyrator given by flows that cannot be turned round

    What: the law of a GY or MGY gives flows, `f1 = g*e2` or `f2 = g*e1`, and its matrix has no
    inverse that is known to exist.

    Why: a gyrator is its ratio r, `e1 = r' f2` and `e2 = r f1`, of which a law of flows is the
    inverse. One number, and a matrix of constants and parameters, is inverted; a matrix that
    varies might become singular during the run.

    Example: `pump : GY { f1 = [[1, 2], [2, 4]]*e2; }`

    Way out: give efforts, `e2 = r*f1` or `e1 = r*f2`.
    """
    return error(
        "BG447",
        f"the ratio of `{name}` cannot be found from its flows: {why}",
        span,
        help="give its efforts: `e2 = r*f1` or `e1 = r*f2`",
    )


def law_variable_misplaced(span: Span, kind: str, left: str, found: str, right: str) -> Diagnostic:
    """BG434: a law in terms of the wrong variable

    What: the right side of a law holds a variable of the element that this law cannot depend on.

    Why: `e = ..` of a C is a function of `q`, `f = ..` of an I of `p`, `e2 = ..` of a TF of
    `e1`, of a GY of `f1`.

    Example: `spring : C { e = k*f; }`

    Way out: use the variable that the message names.
    """
    return error(
        "BG434",
        f"`{left} = ..` of {kind} depends on `{right}`, not on `{found}`",
        span,
        help=f"write it in terms of `{right}`",
    )


def law_variable_is_a_name(span: Span, name: str) -> Diagnostic:
    """BG435: a name that a law uses for itself

    What: a law names a variable of its element, and the model has a value of that name too.

    Why: in a law `e f p q` (of a two-port `e1 f1 e2 f2`) are the element's own.

    Example: `param f = 50 Hz; drag : R { e = 2*f; }`

    Way out: rename the value.
    """
    return error(
        "BG435",
        f"`{name}` is the element's own here, and also a value of this model",
        span,
        help=f"rename the value `{name}`",
    )


def law_not_linear(span: Span, name: str, right: str) -> Diagnostic:
    """BG436: a two-port law that is not linear

    What: a law of a TF or GY is not a matrix times its variable, or a C or I is given as
    `q = ..` or `p = ..` by something that is not.

    Why: the dual law, with the transposed matrix, is derived from it, so that power is
    conserved; a nonlinear law has none. A C or I would have to be inverted.

    Example: `map : MTF { f2 = f1^2; }`

    Way out: write `matrix*variable`, where the matrix may depend on states; for storage write
    `e = ..` in terms of `q` (`f = ..` of `p`), or the energy `H = ..`.
    """
    return error(
        "BG436",
        f"the law of `{name}` is not linear in `{right}`",
        span,
        help=f"write it as a factor or matrix times `{right}`; storage may be given by `H = ..`",
    )


def law_incomplete(
    span: Span, name: str, left: str, width: int, missing: int, how: str = "nowhere"
) -> Diagnostic:
    """BG437: a law without all of its components

    What: a law written by components leaves one out, or gives one twice.

    Why: each of the element's ports needs its equation.

    Example: `field : C[2] { e[1] = q[1]; }`

    Way out: write one equation for each component, or one vector equation.
    """
    return error(
        "BG437",
        f"the law of `{name}` gives `{left}[{missing}]` {how}, and has {width} components",
        span,
        help="write one equation for each component, or one for the whole vector",
    )


def law_too_many(span: Span, name: str, needed: str) -> Diagnostic:
    """BG438: more equations than a law has

    What: a law block holds equations for different variables.

    Why: one equation is the law of a one-port; the dual law of a two-port follows from it.

    Example: `r : R { e = 2*f; f = e/2; }`

    Way out: keep one. A TF may give both directions of a rotation: `f2 = ..` and `f1 = ..`.
    """
    return error("BG438", f"the law of `{name}` has too many equations", span, help=needed)


def wrong_matrix(span: Span, what: str, expected: str, found: str) -> Diagnostic:
    """BG439: a law's matrix of the wrong size

    What: the value given to an element does not fit its width.

    Why: an element of width n has n components of effort and flow.

    Example: `field : C[2](stiffness = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]);`

    Way out: a scalar (for all components alike), a vector (one for each), or an n x n matrix.
    """
    return error(
        "BG439",
        f"{what} is {found}, where {expected} is needed",
        span,
        help="give a scalar, a vector of one for each component, or a matrix",
    )


def modulated(span: Span, name: str, kind: str) -> Diagnostic:
    """BG440: an element that varies without saying so

    What: the law of a TF, GY or R depends on the time, a state or a signal.

    Why: that such an element is modulated matters to its reader; the M says so.

    Example: `lever : TF(ratio = cos(angle));`

    Way out: write MTF, MGY or MR.
    """
    return error(
        "BG440",
        f"`{name}` varies during the run, so it is a modulated element",
        span,
        help=f"write `M{kind}` instead of `{kind}`",
    )


def storage_varies(span: Span, name: str, kind: str) -> Diagnostic:
    """BG441: a storage element that varies

    What: the law of a C or I depends on the time, or on something other than its own state.

    Why: its energy would change without a bond that brings it.

    Example: `spring : C(stiffness = 2 + time);`

    Way out: use constants and parameters; where energy depends on several states, make it one
    element of several ports with an energy law `H = ..`, or put an MTF before the element.
    """
    return error(
        "BG441",
        f"the law of `{name}`, {with_article(kind)}, varies by something other than its own state",
        span,
        help="use constants and parameters, an energy law, or an MTF before it",
    )


def not_skew(span: Span, name: str, row: int, column: int) -> Diagnostic:
    """BG442: a one-sided gyrator that is not skew

    What: the matrix of an MGY with bonds on one side only (eq. 13 of the paper) is not skew:
    `S[i, j]` is not `-S[j, i]`.

    Why: only a skew matrix neither makes nor takes power.

    Example: `gyro : MGY[3] { e = [[0, 1, 0], [1, 0, 0], [0, 0, 0]]*f; }`

    Way out: correct the matrix; what takes power is an R.
    """
    return error(
        "BG442",
        f"the matrix of `{name}` is not skew: entry [{row}, {column}] is not the opposite of "
        f"[{column}, {row}]",
        span,
        help="correct the matrix; what takes power is an R",
    )


def one_sided(span: Span, name: str, kind: str, missing: str) -> Diagnostic:
    """BG443: a two-port with bonds on one side only

    What: a TF or GY has no bond on one of its sides.

    Why: it passes power from the bond that comes in to the one that leaves.

    Example: `a -> gear;`

    Way out: bond the other side. Only an MGY with a skew matrix may have all its bonds on one.
    """
    return error(
        "BG443",
        f"`{name}`, {with_article(kind)}, has no bond {missing} it",
        span,
        help="write `.. -> name -> ..`",
    )


def inverse_differs(span: Span, name: str) -> Diagnostic:
    """BG444: two laws of a transformer that contradict each other

    What: a TF is given in both directions, and one matrix is not the inverse of the other.

    Why: `f2 = m f1` and `f1 = w f2` say the same only if `w m` is the identity.

    Example: `turn : MTF { f2 = transpose(B)*f1; f1 = 2*B*f2; }`

    Way out: correct one, or leave one out.
    """
    return error(
        "BG444",
        f"the two equations of `{name}` are not each other's inverse",
        span,
        help="correct one, or leave it out",
    )


def initial_not_of_this(span: Span, name: str, kind: str, have: Sequence[str]) -> Diagnostic:
    """BG446: an initial value that the element does not take

    What: `p0` is given to a C, or `q0` to an I, or an initial value to something that stores
    nothing.

    Why: a C starts from its displacement `q0` or effort `e0`, an I from its momentum `p0` or
    flow `f0`.

    Example: `coil : I(L, q0 = 1);`

    Way out: give one of those that the message lists.
    """
    listing = " or ".join(f"`{h}`" for h in have)
    return error(
        "BG446",
        f"`{name}` is no initial value of {kind}",
        span,
        help=f"give {listing}" if have else "it stores nothing",
    )


def not_a_state(span: Span, name: str) -> Diagnostic:
    """BG450: the derivative of something that is no state

    What: `der(x) = ..;` or `project x = ..;` is written for something other than a `state` of
    this model.

    Why: only a declared state is integrated.

    Example: `let x = 0; der(x) = 1;`

    Way out: declare it: `state x = 0;`
    """
    return error("BG450", f"`{name}` is no state of this model", span, help="declare it by `state`")


def state_without_equation(span: Span, name: str) -> Diagnostic:
    """BG451: a state without an equation

    What: a `state` has no `der(x) = ..;`, no `equation` holds `der(x)`, and none is left from which
    `x` itself could be found.

    Why: how it changes is not known.

    Example: `state x = 1;` and nothing more.

    Way out: write `der(x) = ..;`. What only depends on others is a `signal`, and what follows from
    an `equation` an `unknown`.
    """
    return error(
        "BG451",
        f"nothing says how the state `{name}` changes",
        span,
        help=f"write `der({name}) = ..;`",
    )


def equations_and_unknowns(span: Span, equations: int, unknowns: int) -> Diagnostic:
    """BG452: the number of equations is not that of the unknowns

    What: the model has more or fewer scalar `equation`s than `unknown`s and states without a
    `der(x) = ..;` of their own.

    Why: each unknown needs one equation to be found from.

    Example: `unknown z = 0;` without an `equation`.

    Way out: add an equation, or remove one; a vector equation counts once for each component.
    """
    return error(
        "BG452",
        f"{equations} equations for {unknowns} unknowns",
        span,
        help="each `unknown`, and each state that only equations hold, needs one equation",
    )


def law_of_junction(span: Span, name: str, kind: str) -> Diagnostic:
    """BG455: a junction with a law

    What: a J0, J1 or Mux has a law block.

    Why: what a junction does is fixed: its bonds share the effort (J0) or the flow (J1).

    Example: `node : J1 { e = 2*f; }`

    Way out: put the law on an element that is bonded to it.
    """
    return error(
        "BG455",
        f"`{name}` is {with_article(kind)}, and takes no law",
        span,
        help="put the law on an element that is bonded to it",
    )
