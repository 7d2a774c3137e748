"""Diagnostics: ensembles of runs."""

from __future__ import annotations

from bgc.diagnostics.catalogue import Values, error


@error(
    "BG740: `{name}` has {count:counted value} and `{other}` {expected:counted value}",
    "give one value for each instance, or a single number for all",
)
def uneven_values(name: str, count: int, other: str, expected: int) -> None: ...
@error(
    "BG741: there are no parameter sets to simulate",
    "give at least one: `simulate_many([{}])` runs the model unchanged",
)
def no_instances() -> None: ...
@error(
    "BG742: `{path}` has changed since this model was compiled",
    "compile it again: `model = bgc.compile(path)`",
)
def source_changed(path: str) -> None: ...
@error(
    "BG743: `{text}` is not {form}",
    'write `"boom.mass=5..9 t:20"`, or values, `"boom.mass=5, 7, 9 t"`',
)
def bad_range(text: str, reason: str = "") -> Values:
    return {"form": f"a range: {reason}" if reason else "of the form name=low..high unit:count"}


@error("BG744: `{name}` is varied twice", "give one range for it, or run two sweeps")
def varied_twice(name: str) -> None: ...
@error(
    "BG745: {count:,} instances exceed the limit of {most:,} in one sweep",
    "use `--sample 1000` to spread points over the ranges, or give smaller counts",
)
def too_many_instances(count: int, most: int) -> None: ...
