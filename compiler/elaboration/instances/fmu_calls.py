"""Enter FMUs of sampled parts: `signal y[2] = fmu("winch.fmu", ["speed", "angle"], "torque", u);`.

At each instant the values of the variables that are set go to the FMU, which then computes a
communication step up to there, and the variables that are read become the held values. The FMU is
initialised at the first instant. The values that are set are held values themselves, so that the
kernel of the sampled parts evaluates them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from bgc.diagnostics.catalogue.fmu_parts import (
    fmu_misused,
    fmu_variable_misused,
    no_fmu_variable,
)
from bgc.diagnostics.catalogue.names import given_twice
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.elaboration.instances.limits import MAX_WIDTH
from bgc.elaboration.instances.tree import Environment, FmuCall, Quantity
from bgc.elaboration.instances.world import World
from bgc.grammar import syntax
from bgc.record_class import replace
from bgc.values.fmu_files import FmuFile, FmuVariable
from bgc.values.units import Dimension

FUNCTION = "fmu"


def is_fmu_call(item: syntax.Value) -> bool:
    """Return whether an output or signal of a sampled part is that of an FMU."""
    return isinstance(item.value, syntax.Call) and item.value.function == FUNCTION


def read_call(world: World, path: str, item: syntax.Value, env: Environment) -> FmuCall:
    """Read the call of an FMU, and the held values of what is read and of what is set.

    Raises
    ------
    BgError
        BG273 where the FMU cannot be read, BG274 for a call of another form, BG275 for a variable
        that it does not have, BG276 for one that cannot be read or set.
    """
    call = item.value
    assert isinstance(call, syntax.Call)
    if len(call.arguments) < 2 or len(call.arguments) % 2:
        raise BgError([fmu_misused(call.span, "`fmu` takes a file, variables, and pairs")])
    name, wanted, *pairs = call.arguments
    file = world.package.fmu_file(_text(name, "the file of `fmu`"), name.span)
    names = wanted.elements if isinstance(wanted, syntax.Vector) else (wanted,)
    read = tuple(_to_read(file, each) for each in names)
    given = sorted(
        _to_set(file, pairs[0::2], pairs[1::2]), key=lambda one: (one[0].reference, one[0].place)
    )
    _require_whole_arrays(file, [variable for variable, _ in given], call.span)
    count = len(read)
    if isinstance(wanted, syntax.Vector) or item.dims:
        found = 1
        for dim in item.dims:
            found *= world.whole(dim, env, "a dimension", 0, MAX_WIDTH)
        if found != count or not item.dims:
            problem = f"`fmu` reads {count} variables here: declare `{item.name}[{count}]`"
            raise BgError([fmu_misused(item.name_span, problem)])
    got = Quantity(path, item, env, None, sampled=True, units=_units(read))
    size = syntax.Number(Fraction(len(given)), None, item.name_span)
    declared = replace(item, name=f"{item.name}.given", dims=(size,), unit=None, kind="signal")
    units = _units([variable for variable, _ in given])
    sent = Quantity(f"{path}.given", declared, env, None, sampled=True, units=units)
    return FmuCall(file, call.span, env, read, tuple(given), got, sent)


def _units(variables: Sequence[FmuVariable]) -> tuple[Dimension | None, ...]:
    return tuple(variable.unit.dimension for variable in variables)


def _text(expr: syntax.Expr, what: str) -> str:
    if not isinstance(expr, syntax.Text):
        raise BgError([fmu_misused(expr.span, f"{what} is a text in quotes")])
    return expr.value


def _found(file: FmuFile, expr: syntax.Expr) -> FmuVariable:
    name = _text(expr, "a variable of an FMU")
    variable = file.variables.get(name)
    if variable is None:
        raise BgError([no_fmu_variable(expr.span, file.shown, name, sorted(file.variables))])
    if not variable.kind:
        what, way = "is no number", "read and set numbers and truth values"
        raise BgError([fmu_variable_misused(expr.span, file.shown, name, what, way)])
    return variable


def _to_read(file: FmuFile, expr: syntax.Expr) -> FmuVariable:
    variable = _found(file, expr)
    if variable.is_set:
        what = f"is {_article(variable.causality)} and has the value that is given to it"
        way = "read an output or a local variable"
        raise BgError([fmu_variable_misused(expr.span, file.shown, variable.name, what, way)])
    return variable


def _to_set(
    file: FmuFile, names: Sequence[syntax.Expr], values: Sequence[syntax.Expr]
) -> Iterator[tuple[FmuVariable, syntax.Expr]]:
    first: dict[str, Span] = {}
    for expr, value in zip(names, values, strict=True):
        variable = _found(file, expr)
        if not variable.is_set:
            what = f"is {_article(variable.causality)}, which nothing sets"
            way = "set inputs and parameters"
            raise BgError([fmu_variable_misused(expr.span, file.shown, variable.name, what, way)])
        if variable.name in first:
            raise BgError([given_twice(expr.span, variable.name, first[variable.name])])
        first[variable.name] = expr.span
        yield variable, value


def _require_whole_arrays(file: FmuFile, given: Sequence[FmuVariable], span: Span) -> None:
    """Require all components of each array of FMI 3: an FMU takes an array as a whole."""
    counts: dict[int, int] = {}
    for variable in given:
        counts[variable.reference] = counts.get(variable.reference, 0) + 1
    for variable in given:
        if file.version == 3 and counts[variable.reference] != variable.count:
            what = f"is one of {variable.count} components, which are set together"
            way = "give a value to each component of the array"
            raise BgError([fmu_variable_misused(span, file.shown, variable.name, what, way)])


def _article(causality: str) -> str:
    words = {
        "input": "an input",
        "output": "an output",
        "parameter": "a parameter",
        "calculatedParameter": "a calculated parameter",
        "independent": "the time",
    }
    return words.get(causality, f"a {causality} variable")
