"""Diagnostics of shapes and indices of values."""

from __future__ import annotations

from bgc.diagnostics.catalogue import error
from bgc.diagnostics.diagnostic import Diagnostic, Label
from bgc.diagnostics.source import Span


def shapes_differ(context: str, left: tuple[Span, str], right: tuple[Span, str]) -> Diagnostic:
    """BG310: shapes that do not match

    What: two values are combined component by component, but have different shapes.

    Why: `+`, `-`, `if`, `min` and similar operations need equal shapes; a scalar is not repeated
    silently.

    Example: `let v = [1, 2, 3] + 1;`

    Way out: make both shapes equal, for example `[1, 2, 3] + ones(3)`.
    """
    return error(
        "BG310",
        f"{left[1]} and {right[1]} have different shapes in {context}",
        right[0],
        labels=(Label(left[0], left[1]),),
        help="give both the same shape",
    )


def no_product(left: tuple[Span, str], right: tuple[Span, str], help: str) -> Diagnostic:
    """BG311: shapes that have no product

    What: the columns of the left factor are not as many as the rows of the right one, or both are
    vectors.

    Why: `*` is the product of scalars and matrices. Two vectors have three products, each with its
    own name.

    Example: `let power = [1, 2, 3]*[4, 5, 6];`

    Way out: use `dot(a, b)`, `cross(a, b)` or `outer(a, b)` for vectors, and `transpose(A)*b` if
    the matrix is transposed.
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

    What: a vector or matrix is used where only a single number makes sense: as a divisor, a base or
    exponent, a condition, or an argument of `atan2`.

    Why: division by a vector is undefined, and a vector is neither true nor false.

    Example: `let x = 1/[1, 2, 3];`

    Way out: use one component, for example `v[2]` or `v.x`.
    """
    way_out = help or "use one component, for example `v[2]` or `v.x`"
    return error("BG312", f"{what} must be a scalar, not {found}", span, help=way_out)


def wrong_argument_shape(span: Span, function: str, expected: str, found: str) -> Diagnostic:
    """BG313: an argument of the wrong shape

    What: a function is given an argument of a shape that it does not accept.

    Why: `cross` takes vectors of 3, `inv` a square matrix, and so on.

    Example: `let n = cross([1, 0], [0, 1]);`

    Way out: give an argument of the shape that the message names.
    """
    message = f"`{function}` takes {expected}, not {found}"
    return error("BG313", message, span, help=f"give it {expected}")


def ragged(span: Span, expected: str, found: str) -> Diagnostic:
    """BG314: rows of different lengths

    What: the elements of a vector literal are neither all scalars nor all vectors of the same
    length.

    Why: `[a, b]` is a vector of scalars, `[[a, b], [c, d]]` a matrix by rows.

    Example: `let A = [[1, 2], [3]];`

    Way out: give each row as many elements as the first. To join vectors use `stack(a, b)`, to join
    matrices `stack` or `block`.
    """
    return error(
        "BG314",
        f"this element is {found}, the first is {expected}",
        span,
        help="use `stack(a, b)` to join vectors, `block([[A, B], [C, D]])` to join matrices",
    )


def wrong_shape(span: Span, what: str, expected: str, found: str) -> Diagnostic:
    """BG315: a value of the wrong shape

    What: the shape of a value is not the declared one.

    Why: all shapes are fixed at compile time.

    Example: `param axis[3] = [0, 1];`

    Way out: give as many components as declared.
    """
    message = f"{what} must be {expected}, not {found}"
    return error("BG315", message, span, help="give as many components as declared")


def blocks_differ(span: Span, what: str) -> Diagnostic:
    """BG316: blocks that do not match

    What: the matrices in a row of `block`, or below each other, have different sizes, or its
    argument is not a matrix of matrices.

    Why: blocks in a row have the same height, blocks in a column the same width.

    Example: `let A = block([[eye(3), zeros(2, 3)]]);`

    Way out: correct the sizes; write `0` for a block of zeros of the right size.
    """
    return error("BG316", what, span, help="write `block([[A, B], [C, D]])`, by rows")


def too_large(span: Span, what: str) -> Diagnostic:
    """BG317: a value that is too large

    What: a value has more than 100,000 components, or a product of matrices would take millions of
    operations.

    Why: each component becomes separate code; such a size is usually a typing error.

    Example: `let v = zeros(1000000000);`

    Way out: use a smaller size.
    """
    return error("BG317", f"{what} is too large", span, help="use a smaller size")


def too_deep(span: Span) -> Diagnostic:
    """BG318: an expression nested too deeply

    What: an expression, with the functions that it calls, is nested more than 150 operations deep.

    Why: the compiler follows the nesting recursively, with limited memory.

    Example: a hundred functions that each call the one before.

    Way out: name inner parts of the expression with `let`.
    """
    return error(
        "BG318",
        "this expression is nested too deeply",
        span,
        help="name inner parts of it with `let`",
    )


def too_many_dimensions(span: Span, name: str, found: int) -> Diagnostic:
    """BG319: more than two dimensions

    What: a value is declared with three or more dimensions in brackets.

    Why: values are scalars, vectors and matrices.

    Example: `state u[8, 8, 8];`

    Way out: combine two dimensions into one: `state u[64, 8]` with the index `u[8*(i - 1) + j, k]`.
    Or declare a vector inside a `for`: `for i in 1..8 { signal w[8]; }`.
    """
    return error(
        "BG319",
        f"`{name}` has {found} dimensions, but a value has at most two",
        span,
        help="combine two dimensions into one, for example `u[8*(i - 1) + j, k]`",
    )


def index_out_of_range(span: Span, index: int, size: int, shape: str) -> Diagnostic:
    """BG320: an index out of range

    What: an index is less than 1, or greater than the number of components.

    Why: indices run from 1 to the number of components.

    Example: `param v[3] = [1, 2, 3]; let x = v[0];`

    Way out: use an index from 1 to the number of components.
    """
    return error(
        "BG320",
        f"there is no component {index} in {shape}",
        span,
        help=f"use an index from 1 to {size}",
    )


def wrong_index_count(span: Span, shape: str, expected: int, found: int) -> Diagnostic:
    """BG321: too many or too few indices

    What: a vector takes one index, a matrix two, a scalar none.

    Why: `A[2]` of a matrix could be a row, a column or an element.

    Example: `const A = eye(3); let row = A[2];`

    Way out: write `A[2, 1..3]` for row 2 of a matrix with 3 columns.
    """
    needs = ("no index", "one index", "two indices")[expected]
    return error(
        "BG321",
        f"{shape} takes {needs}, not {found}",
        span,
        help="write `A[2, 1..3]` for a row" if expected == 2 else "remove the extra indices",
    )


def empty_range(span: Span, first: int, last: int) -> Diagnostic:
    """BG322: an empty range of indices

    What: the first index of a range is greater than the last.

    Why: a range includes both ends, so it has at least one component.

    Example: `param v[3] = [1, 2, 3]; let w = v[3..1];`

    Way out: write the smaller index first.
    """
    return error(
        "BG322",
        f"the range {first}..{last} is empty",
        span,
        help=f"write `{last}..{first}`" if first - last > 1 else "write the smaller index first",
    )


def no_component(span: Span, name: str, shape: str) -> Diagnostic:
    """BG323: no component of that name

    What: the name after a dot is not a component of the value: a vector has only `.x`, `.y` and
    `.z`, its first three components.

    Why: a value is a scalar, a vector or a matrix; only parts of models have members.

    Example: `param v[3] = [1, 2, 3]; let a = v.w;`

    Way out: use an index, for example `v[2]`.
    """
    return error(
        "BG323",
        f"{shape} has no component `{name}`",
        span,
        help="use `.x`, `.y`, `.z` of a vector, or an index `[1]`, `[2]`, ..",
    )


def no_range_of_parts(span: Span, what: str) -> Diagnostic:
    """BG324: a range of parts in an expression

    What: an expression uses a range of an array of parts.

    Why: parts have no common value; a range selects components of a vector or matrix.

    Example: `node : J1; for i in 1..3 { mass[i] : I(1); node -> mass[i]; }
    let p = mass[1..3].p;`

    Way out: name the parts one by one: `[mass[1].p, mass[2].p]`.
    """
    return error(
        "BG324",
        f"a range cannot select from {what} in an expression",
        span,
        help="name one part, for example `mass[2].p`",
    )
