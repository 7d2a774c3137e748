"""Diagnostics of shapes and indices of values."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def shapes_differ(context: str, left: tuple[Span, str], right: tuple[Span, str]) -> Diagnostic:
    """BG310: shapes that do not go together

    What: two values are combined component by component, but have not the same shape.

    Why: `+`, `-`, `if`, `min` and their like need equal shapes; nothing is repeated silently.

    Example: `let v = [1, 2, 3] + 1;`

    Way out: build the other vector too, for instance `[1, 2, 3] + ones(3)`.
    """
    return error(
        "BG310",
        f"{left[1]} and {right[1]} do not go together in {context}",
        right[0],
        labels=(Label(left[0], left[1]),),
        help="both must have the same shape",
    )


def no_product(left: tuple[Span, str], right: tuple[Span, str], help: str) -> Diagnostic:
    """BG311: shapes that have no product

    What: the columns of the left factor are not as many as the rows of the right one, or both
    are vectors.

    Why: `*` is the product of scalars and matrices. Of two vectors there are three products,
    and each has a name.

    Example: `let power = [1, 2, 3]*[4, 5, 6];`

    Way out: `dot(a, b)`, `cross(a, b)` or `outer(a, b)` of vectors; `transpose(A)*b` where the
    matrix lies the other way.
    """
    return error(
        "BG311",
        f"there is no product of {left[1]} and {right[1]}",
        right[0],
        labels=(Label(left[0], left[1]),),
        help=help,
    )


def needs_scalar(span: Span, what: str, found: str, help: str = "") -> Diagnostic:
    """BG312: a scalar is needed

    What: a vector or matrix stands where only a single number has a meaning: a divisor, a
    base or exponent, a condition, an argument of `atan2`.

    Why: there is no division by a vector, and no vector is true or false.

    Example: `let x = 1/[1, 2, 3];`

    Way out: pick one component, as in `v[2]` or `v.x`.
    """
    way_out = help or "pick one component, as in `v[2]` or `v.x`"
    return error("BG312", f"{what} must be a scalar, not {found}", span, help=way_out)


def wrong_argument_shape(span: Span, function: str, expected: str, found: str) -> Diagnostic:
    """BG313: an argument of the wrong shape

    What: a function is given a scalar, vector or matrix of a shape it is not made for.

    Why: `cross` takes vectors of 3, `inv` a square matrix, and so on.

    Example: `let n = cross([1, 0], [0, 1]);`

    Way out: give an argument of the shape the message asks for.
    """
    message = f"`{function}` takes {expected}, not {found}"
    return error("BG313", message, span, help=f"give it {expected}")


def ragged(span: Span, expected: str, found: str) -> Diagnostic:
    """BG314: rows of different lengths

    What: the elements of a vector literal are not all scalars, or not all vectors of one
    length.

    Why: `[a, b]` is a vector of scalars, `[[a, b], [c, d]]` a matrix by rows.

    Example: `let A = [[1, 2], [3]];`

    Way out: give each row as many elements as the first. To join vectors use `stack(a, b)`,
    to join matrices `stack` or `block`.
    """
    return error(
        "BG314",
        f"this element is {found}, the first is {expected}",
        span,
        help="`stack(a, b)` joins vectors, `block([[A, B], [C, D]])` matrices",
    )


def wrong_shape(span: Span, what: str, expected: str, found: str) -> Diagnostic:
    """BG315: a value of the wrong shape

    What: a value is given whose shape is not the one declared.

    Why: the number of components of everything is fixed at compile time.

    Example: `param axis[3] = [0, 1];`

    Way out: give as many components as declared.
    """
    message = f"{what} must be {expected}, not {found}"
    return error("BG315", message, span, help="give as many components as declared")


def blocks_differ(span: Span, what: str) -> Diagnostic:
    """BG316: blocks that do not fit

    What: the matrices in one row of `block`, or below each other, have different sizes, or
    its argument is no matrix of matrices.

    Why: blocks beside each other share their height, blocks above each other their width.

    Example: `let A = block([[eye(3), zeros(2, 3)]]);`

    Way out: correct the sizes; a plain `0` stands for a block of zeros of the size that fits.
    """
    return error("BG316", what, span, help="write `block([[A, B], [C, D]])`, by rows")


def too_large(span: Span, what: str) -> Diagnostic:
    """BG317: larger than the compiler is made for

    What: a value of more than 100,000 components is asked for, or a product of matrices that
    would take millions of operations.

    Why: every component becomes code of its own; this is most often a slip of the keyboard.

    Example: `let v = zeros(1000000000);`

    Way out: use a smaller size.
    """
    return error("BG317", f"{what} is too large", span, help="use a smaller size")


def too_deep(span: Span) -> Diagnostic:
    """BG318: nested too deeply

    What: an expression and the functions that it calls nest more than 150 operations deep.

    Why: the compiler follows them one within the other, and its memory for that is bounded.

    Example: a hundred functions, each of which calls the one before it.

    Way out: name inner parts of the expression with `let`, and pass these on.
    """
    return error(
        "BG318", "this expression is nested too deeply", span, help="break it up into several"
    )


def too_many_dimensions(span: Span, name: str, found: int) -> Diagnostic:
    """BG319: more than two dimensions

    What: a value is declared with three or more dimensions in brackets.

    Why: values are scalars, vectors and matrices; products and indices are theirs.

    Example: `state u[8, 8, 8];`

    Way out: count two of the dimensions in one, as in `state u[64, 8]` with the index
    `u[8*(i - 1) + j, k]`, or declare a vector inside a `for`: `for i in 1..8 { signal w[8]; }`.
    """
    return error(
        "BG319",
        f"`{name}` has {found} dimensions, and a value has two at most",
        span,
        help="count two dimensions in one, as `u[8*(i - 1) + j, k]`",
    )


def index_out_of_range(span: Span, index: int, size: int, shape: str) -> Diagnostic:
    """BG320: an index out of range

    What: an index is less than 1, or more than there are components.

    Why: components count from 1, and the last of `n` is `n`.

    Example: `param v[3] = [1, 2, 3]; let x = v[0];`

    Way out: use an index from 1 to the number of components.
    """
    return error(
        "BG320", f"there is no component {index} in {shape}", span, help=f"count from 1 to {size}"
    )


def wrong_index_count(span: Span, shape: str, expected: int, found: int) -> Diagnostic:
    """BG321: too many or too few indices

    What: a vector takes one index, a matrix two, a scalar none.

    Why: `A[2]` of a matrix could be a row, a column or an element.

    Example: `const A = eye(3); let row = A[2];`

    Way out: `A[2, 1..3]` is row 2 of a matrix with 3 columns.
    """
    needs = ("no index", "one index", "two indices")[expected]
    return error(
        "BG321",
        f"{shape} takes {needs}, not {found}",
        span,
        help="a row of a matrix is `A[2, 1..3]`" if expected == 2 else "leave out what is too much",
    )


def empty_range(span: Span, first: int, last: int) -> Diagnostic:
    """BG322: a range that runs backwards

    What: the first index of a range is more than the last.

    Why: a range holds both its ends, so it has at least one component.

    Example: `param v[3] = [1, 2, 3]; let w = v[3..1];`

    Way out: write the smaller index first.
    """
    return error(
        "BG322",
        f"the range {first}..{last} is empty",
        span,
        help=f"write `{last}..{first}`"
        if first - last > 1
        else "the first must not exceed the last",
    )


def no_component(span: Span, name: str, shape: str) -> Diagnostic:
    """BG323: no component of that name

    What: `.x`, `.y` and `.z` are the first three components of a vector, and a value has no
    other members.

    Why: a value is a scalar, a vector or a matrix; only parts of models have members.

    Example: `param v[3] = [1, 2, 3]; let a = v.w;`

    Way out: use an index, as in `v[2]`.
    """
    return error(
        "BG323",
        f"{shape} has no component `{name}`",
        span,
        help="components are `.x`, `.y`, `.z` of a vector, or `[1]`, `[2]`, ..",
    )


def no_range_of_parts(span: Span, what: str) -> Diagnostic:
    """BG324: a range of parts in an expression

    What: an expression takes a range of an array of parts.

    Why: parts have no common value; a range picks components of a vector or matrix.

    Example: `node : J1; for i in 1..3 { mass[i] : I(1); node -> mass[i]; }
    let p = mass[1..3].p;`

    Way out: name the parts one by one: `[mass[1].p, mass[2].p]`.
    """
    return error(
        "BG324",
        f"a range cannot pick from {what} in an expression",
        span,
        help="name one part: `mass[2].p`",
    )
