"""Diagnostics of `jacobian`, of random numbers, and of data and interpolation."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import did_you_mean, error, listed
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span

# --- jacobian ---------------------------------------------------------------------------


def jacobian_by_expression(span: Span) -> Diagnostic:
    """BG475: a derivative by an expression

    What: the second argument of `jacobian` is an expression, a constant, or a variable of a bond
    that is itself computed.

    Why: a partial derivative is by a quantity that can be varied while all others are held: a
    state, an input, a signal, an output, a parameter, or the time.

    Example: `state x = 1; let g = jacobian(sin(2*x), 2*x);`

    Way out: name the quantity, and use the name in the first argument:
    `signal phase = 2*x; let g = jacobian(sin(phase), phase);`.
    """
    return error(
        "BG475",
        "`jacobian` differentiates by states, signals and inputs, not by an expression",
        span,
        help="give the expression a name with `signal`, use the name in both arguments",
    )


def jacobian_of_matrix(span: Span, found: str) -> Diagnostic:
    """BG476: the derivative of a matrix

    What: the first argument of `jacobian` is a matrix.

    Why: the derivatives of a vector by a list are a matrix; those of a matrix would need three
    indices.

    Example: `state x = 1; let d = jacobian([[x, 0], [0, x]], x);`

    Way out: differentiate each row or column: `jacobian(A[1, 1..2], x)`.
    """
    return error(
        "BG476",
        f"`jacobian` differentiates a scalar or a vector, not {found}",
        span,
        help="differentiate its rows or columns one by one",
    )


# --- random numbers ---------------------------------------------------------------------


def random_of_what_varies(span: Span, what: str, found: str) -> Diagnostic:
    """BG477: a random number of something other than whole constants

    What: the seed or the index of `random` changes during a run, or is not a whole number below
    2^53.

    Why: a random number is a function of its seed and its index, so that it is the same on every
    machine and in every run. A number that changed with the state would be noise without an
    equation.

    Example: `let phase = 2*pi*random(1, time);`

    Way out: number the draws: `for i in 1..20 { let phase = 2*pi*random(seed, i); }`, with
    `param seed = 1;`.
    """
    return error(
        "BG477",
        f"{what} of `random` must be a whole number"
        + (f", not {found}" if found else " that is known before the run"),
        span,
        help="use a constant, a parameter or the variable of a `for`",
    )


# --- data files -------------------------------------------------------------------------


def data_unreadable(span: Span, file: str, why: str) -> Diagnostic:
    """BG250: a data file that cannot be read

    What: the file of `data("..")` does not exist, is not a file of UTF-8 text, is larger than
    256 MB, or is neither `.csv` nor `.json`.

    Why: the file is read when the model is compiled. Its path is relative to the `.bg` file that
    names it; on the command line, to the working folder.

    Example: `const road = data("raod.csv");`

    Way out: correct the path, or save the file as comma-separated UTF-8 text.
    """
    return error(
        "BG250",
        f"cannot read data from `{file}`: {why}",
        span,
        help="give the path relative to this file, of a `.csv` or `.json` file in UTF-8",
    )


def data_malformed(span: Span, file: str, problem: str) -> Diagnostic:
    """BG251: a data file whose contents are not numbers by name

    What: a line of a CSV file has too many or too few values, something that is not a finite
    number, or a header is missing or repeated; or a JSON file is not an object of numbers, vectors
    and matrices.

    Why: the first line of a CSV file names the columns; every further line has one number for each.
    A gap or a `NaN` of a logger would reach the simulation as a value.

    Example: a line `0.2,,1.5`, or `0.2 0.3` where the header is `time,z`.

    Way out: correct the file at the line that the message names; leave out rows with gaps.
    """
    return error(
        "BG251",
        f"`{file}` is not a table of numbers: {problem}",
        span,
        help="correct the file: a line of names, then one finite number per column in each line",
    )


def data_unit(span: Span, file: str, title: str, unit: str, suggestion: str) -> Diagnostic:
    """BG252: an unknown unit in a data file

    What: the brackets of a column's title, or of a key, hold no unit.

    Why: `z [mm]` says that the numbers are millimetres. They are converted to SI units when the
    file is read, and checked where they are used.

    Example: the header `time [sec],z [m]`.

    Way out: write a unit of the language, `time [s]`, or leave the brackets out.
    """
    return error(
        "BG252",
        f"`{unit}` is not a unit, in `{title}` of `{file}`",
        span,
        help=f"write `{suggestion}`" if suggestion else "write a unit such as `mm` or `kN*m`",
    )


def data_missing_name(span: Span, name: str, owner: str, have: Sequence[str]) -> Diagnostic:
    """BG253: a column or key that the data does not have

    What: a data file has no column, or no key, of that name.

    Why: a column is named by its title without the unit, `road.z` or `road["z pos"]`; a key within
    another one by a path, `ship.hull.mass`.

    Example: `const road = data("road.csv"); let z = road.height;` with the header `time,z`.

    Way out: use one of the names that the message lists.
    """
    near = did_you_mean(name, have)
    return error(
        "BG253",
        f"{owner} has no `{name}`, but {listed(have) or 'nothing'}",
        span,
        help=near or "use one of these names",
    )


def data_too_long(span: Span, name: str, size: int, most: int) -> Diagnostic:
    """BG254: a long column used as a vector

    What: a column or matrix of more than 10,000 numbers stands where an expression uses each
    of them.

    Why: `interpolate` keeps a column as one table, whatever its length. Anything else makes an
    expression of each number.

    Example: `let average = sum(road.z)/length(road.z);` with 1,000,000 rows.

    Way out: use `interpolate`, `length`, single numbers or a slice, as `road.z[1..100]`, or
    compute the value where the file is made.
    """
    return error(
        "BG254",
        f"`{name}` has {size:,} numbers, too many for a vector of expressions (at most {most:,})",
        span,
        help="use `interpolate`, single numbers or a slice such as `[1..100]`",
    )


def data_name_expected(span: Span) -> Diagnostic:
    """BG255: `data` without the name of a file

    What: `data` takes one text, the path of a file, and stands in a `const` or an expression of
    constants.

    Why: the file is read when the model is compiled, so its name cannot depend on a parameter.

    Example: `const road = data(road.csv);`

    Way out: put the path in quotes: `data("road.csv")`.
    """
    return error(
        "BG255", "`data` takes the path of a file in quotes", span, help='write `data("road.csv")`'
    )


# --- interpolation ----------------------------------------------------------------------


def too_few_knots(span: Span, name: str, found: int) -> Diagnostic:
    """BG256: data that cannot be interpolated

    What: the first arguments of `interpolate` have fewer than two numbers, or the numbers of values
    and knots differ.

    Why: there is one value for each knot; in two dimensions `Z[i, j]` is the value at `xs[i]` and
    `ys[j]`.

    Example: `let y = interpolate([0, 1, 2], [5, 6], x);`

    Way out: give a value for each knot, and at least two knots.
    """
    return error(
        "BG256",
        f"`{name}` has {found} value{'s' if found != 1 else ''}; `interpolate` needs at least 2",
        span,
        help="give at least two knots",
    )


def data_lengths(span: Span, name: str, found: str, needed: str) -> Diagnostic:
    """Report values that are not as many as the knots, as BG256."""
    return error(
        "BG256",
        f"`{name}` is {found}, but the knots need {needed}",
        span,
        help="give one value for each knot: `Z[i, j]` is the value at `xs[i]` and `ys[j]`",
    )


def knots_fall(span: Span, name: str, place: int, before: float, after: float) -> Diagnostic:
    """BG257: knots that do not rise

    What: the first argument of `interpolate`, or the second of two dimensions, does not rise from
    each number to the next.

    Why: between two equal knots the value would be undefined.

    Example: `let y = interpolate([0, 1, 1, 2], [0, 0, 5, 5], x);`

    Way out: sort the rows and remove repeated ones; write a jump as two knots close to each other.
    """
    return error(
        "BG257",
        f"`{name}` does not rise: number {place} is {after:.15g}, after {before:.15g}",
        span,
        help="sort the rows and remove repeated ones",
    )


def repeat_jumps(span: Span, name: str, first: float, last: float) -> Diagnostic:
    """BG258: a period that does not end where it begins

    What: the data of `interpolate(.., outside = repeat)` end with a value other than their first
    one.

    Why: the last knot is the first one of the next period, so both have one value. A curve with
    two would jump once in every period.

    Example: `interpolate([0, 1, 2], [0, 5, 3], time, outside = repeat)`

    Way out: add a last row with the first value, at the end of the period.
    """
    return error(
        "BG258",
        f"`{name}` begins with {first:.15g} and ends with {last:.15g}, so it cannot repeat",
        span,
        help="add a last row with the first value, at the end of the period",
    )


def interpolate_option(span: Span, name: str, value: str, allowed: Sequence[str]) -> Diagnostic:
    """BG259: an unknown option of `interpolate`

    What: a named argument is neither `method` nor `outside`, is given twice, or has a value that is
    not available.

    Why: `method` is `linear`, `pchip` (monotone), `spline` (smooth) or `nearest`; `outside` is
    `hold`, `error`, `extrapolate` or `repeat`. In two dimensions there is no `pchip`, for no
    monotone surface is singled out.

    Example: `interpolate(road.x, road.z, x, method = cubic)`

    Way out: use one of the values that the message lists.
    """
    if not value:
        message = f"`interpolate` takes no `{name}` here"
        way = f"its options are {listed(allowed)}, once each"
    else:
        message = f"`{value}` is not a {name} of `interpolate` here"
        way = f"use {listed(allowed)}"
    return error("BG259", message, span, help=way)
