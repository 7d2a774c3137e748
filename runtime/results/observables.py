"""Observables of a run: `max(tension) from 20 s`, one number for each run, and criteria on them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from bgc.diagnostics.catalogue import did_you_mean
from bgc.diagnostics.catalogue.arguments import unknown_column
from bgc.diagnostics.catalogue.studies import bad_observable
from bgc.diagnostics.diagnostic import BgError
from bgc.language.column_names import column_of, component_of, name_in_si
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array
from bgc.values.shown_units import Shown

_FORM = re.compile(
    r"(?P<function>\w+)\s*\((?P<inside>.*)\)\s*"
    r"(?:from\s+(?P<start>.+?))?\s*(?:(?<!\S)to\s+(?P<end>.+?))?\s*"
)
_COMPARISON = re.compile(r"(?P<left>.+?)\s*(?P<sign><=|>=|<|>)\s*(?P<limit>[^<>=]+)")


def _mean(x: Array, weights: Array, _: float) -> float:
    return float(weights @ x)


def _rms(x: Array, weights: Array, _: float) -> float:
    return float(np.sqrt(weights @ (x * x)))


def _sd(x: Array, weights: Array, _: float) -> float:
    return float(np.sqrt(weights @ (x - weights @ x) ** 2))


def _crossings(x: Array, _: Array, level: float) -> float:
    return float(np.count_nonzero((x[:-1] < level) & (x[1:] >= level)))


def _at(place: int | np.intp, x: Array, factor: float = 1.0) -> Array:
    """The gradient of `factor` times the value of one row."""
    found = np.zeros(len(x))
    found[place] = factor
    return found


def _at_extreme(x: Array, factor: float = 1.0) -> Array:
    """The gradient of `factor` times the largest value, that of the parabola through three rows."""
    place = int(x.argmax())
    found = _at(place, x, factor)
    if 0 < place < len(x) - 1:
        before, here, after = x[place - 1 : place + 2]
        bend = 2 * here - before - after
        off = (after - before) / (2 * bend) if bend > 0 else 0.0  # of the vertex, in rows
        weights = off * (off - 1) / 2, 1 - off * off, off * (off + 1) / 2
        found[place - 1 : place + 2] = factor * np.array(weights)
    return found


def _by_norm(x: Array, weights: Array) -> Array:
    """The gradient of the root of the weighted squares, 0 where these vanish."""
    size = np.sqrt(weights @ (x * x))
    return np.asarray(weights * x / size if size > 0 else 0 * x)


def _by_quantile(x: Array, _: Array, share: float) -> Array:
    order = np.argsort(x, kind="stable")
    place, part = divmod(share * (len(x) - 1), 1)
    upper = min(int(place) + 1, len(x) - 1)
    return _at(order[int(place)], x, 1 - part) + _at(order[upper], x, part)


def _by_peak(x: Array, _weights: Array, _argument: float) -> Array:
    return _at_extreme(x) if x.max() >= -x.min() else _at_extreme(-x, -1.0)


_Function = Callable[[Array, Array, float], float]
_Gradient = Callable[[Array, Array, float], Array]

# Name: the reduction of the values at the rows, their weights (the share of time that a row stands
# for) and an argument; its derivatives by the values, if it has any; the kind of the argument;
# whether the result has the unit of the column.
_FUNCTIONS: Mapping[str, tuple[_Function, _Gradient | None, str, bool]] = MappingProxyType(
    {
        "max": (lambda x, w, a: float(x.max()), lambda x, w, a: _at_extreme(x), "", True),
        "min": (lambda x, w, a: float(x.min()), lambda x, w, a: _at_extreme(-x), "", True),
        "mean": (_mean, lambda x, w, a: w, "", True),
        "rms": (_rms, lambda x, w, a: _by_norm(x, w), "", True),
        "sd": (_sd, lambda x, w, a: _by_norm(x - w @ x, w), "", True),
        "range": (
            lambda x, w, a: float(x.max() - x.min()),
            lambda x, w, a: _at_extreme(x) - _at_extreme(-x),
            "",
            True,
        ),
        "peak": (lambda x, w, a: float(np.abs(x).max()), _by_peak, "", True),
        "first": (lambda x, w, a: float(x[0]), lambda x, w, a: _at(0, x), "", True),
        "last": (lambda x, w, a: float(x[-1]), lambda x, w, a: _at(-1, x), "", True),
        "quantile": (lambda x, w, a: float(np.quantile(x, a)), _by_quantile, "share", True),
        "crossings": (_crossings, None, "level", False),
        "above": (lambda x, w, a: float(w @ (x > a)), None, "level", False),
    }
)
FUNCTIONS = tuple(_FUNCTIONS)
EXTREMES = ("max", "min", "peak", "range")  # observables that are looked for between rows too
STEPPED = tuple(name for name, (_, by, _, _) in _FUNCTIONS.items() if by is None)  # count rows

_NUMBER = Shown("1")

Reader = Callable[[str, str, str], float]
"""Reads a number with its unit as an SI value: text, name for messages, SI unit."""


@dataclass(frozen=True, slots=True)
class Observable:
    """One number of a run: a function of an observed column between two times, s.

    `name` is its text. Extremes are looked for at instants between the rows too, see `Reducer`.
    `mean`, `rms`, `sd` and `above` weight the rows by the trapezoidal rule; `quantile`
    interpolates linearly between the sorted rows. `crossings` counts upward crossings of a level,
    `above` is the share of time above one, `peak` the largest magnitude.
    """

    name: str
    function: str
    column: str
    argument: float = 0.0
    start: float = 0.0
    end: float = float("inf")
    unit: str = ""
    shown: Shown = _NUMBER

    def of(self, time: Array, values: Array) -> float:
        """Compute it from a column; NaN where a row of its part of the run is not finite."""
        some = (time >= self.start) & (time <= self.end)
        x, t = values[some], time[some]
        if not len(x) or not np.isfinite(x).all():
            return float("nan")
        reduce, _, _, _ = _FUNCTIONS[self.function]
        return reduce(x, _weights(t), self.argument)

    def gradient(self, time: Array, values: Array) -> Array:
        """Compute its derivatives by the values of a column, all of which are finite, (rows,).

        Extremes have that of the vertex of a parabola. `crossings` and `above` have none.
        """
        some = (time >= self.start) & (time <= self.end)
        _, by, _, _ = _FUNCTIONS[self.function]
        assert by is not None
        found = np.zeros(len(time))
        found[some] = by(values[some], _weights(time[some]), self.argument)
        return found


@dataclass(frozen=True, slots=True)
class Criterion:
    """A demand on an observable: it has to be below (or above) a limit, SI."""

    observable: Observable
    below: bool
    limit: float

    @property
    def name(self) -> str:
        """The criterion as a text in the unit of its column."""
        sign = "<" if self.below else ">"
        return f"{self.observable.name} {sign} {self.observable.shown.text(self.limit)}"

    def margin(self, value: Array) -> Array:
        """The distance to the limit, SI, positive where the criterion holds."""
        return np.asarray(self.limit - value if self.below else value - self.limit)

    def utilisation(self, value: Array) -> Array:
        """Value over limit for `<`, limit over value for `>`, above 1 where it does not hold.

        Where limit or value has the other sign or is zero, it is 0 or 2: a ratio has no meaning.
        """
        value = np.asarray(value, dtype=float)
        top, bottom = (value, self.limit) if self.below else (self.limit, value)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.asarray(np.divide(top, bottom), dtype=float)
        plain = np.where(self.margin(value) > 0, 0.0, 2.0)
        usable = (np.asarray(bottom) > 0) & (np.asarray(top) >= 0)
        found = np.where(usable, ratio, plain)
        return np.where(np.isnan(value), np.nan, found)


def _weights(time: Array) -> Array:
    """Weights of the rows by the trapezoidal rule, of sum 1."""
    if len(time) == 1:
        return np.ones(1)
    halves = np.diff(time) / 2
    weights = np.concatenate((halves, [0.0])) + np.concatenate(([0.0], halves))
    return np.asarray(weights / weights.sum())


def read_observables(
    texts: Sequence[str],
    columns: Mapping[str, tuple[str, Shown]],
    read: Reader,
) -> tuple[Observable, ...]:
    """Read texts such as `max(tension)`; of a vector, one observable for each component.

    `columns` are the observed columns with their SI units and the units in which they are shown.

    Raises BgError: BG787 for another text, BG065 for an unknown column, BG062 or BG063 for a number
    or its unit.
    """
    found = [each for text in texts for each in _read(text, columns, read)]
    return tuple({each.name: each for each in found}.values())


def check_parts(observables: Sequence[Observable], times: Array) -> None:
    """Raise BG787 for an observable whose part of the run holds no row of a run, at these times."""
    for each in observables:
        if not ((times >= each.start) & (times <= each.end)).any():
            reason = f"no row of the run lies in its part; the run ends at {times[-1]:g} s"
            way_out = (
                "move `from .. to ..` into the run, or give a longer `--time` or less `--every`"
            )
            raise BgError([bad_observable(each.name, reason, way_out)])


def read_criterion(
    text: str, columns: Mapping[str, tuple[str, Shown]], read: Reader
) -> tuple[Criterion, ...]:
    """Read `max(tension) < 300 kN`, or `tension < 300 kN`, which stands for its largest value.

    Raises BgError as `read_observables` does.
    """
    match = _COMPARISON.fullmatch(text.strip())
    if match is None:
        raise BgError(
            [bad_observable(text, "it compares nothing", "write `max(tension) < 300 kN`")]
        )
    below = match["sign"].startswith("<")
    left = match["left"].strip()
    if _FORM.fullmatch(left) is None:
        left = f"{'max' if below else 'min'}({left})"
    limit = match["limit"]
    return tuple(
        Criterion(each, below, in_column_unit(limit, f"the limit of {each.name}", each.unit, read))
        for each in _read(left, columns, read)
    )


def _read(
    text: str, columns: Mapping[str, tuple[str, Shown]], read: Reader
) -> Iterator[Observable]:
    text = " ".join(text.split())
    match = _FORM.fullmatch(text)
    if match is None:
        raise BgError([bad_observable(text, "it is not of the form `function(column)`")])
    function = match["function"]
    if function not in _FUNCTIONS:
        reason = f"there is no function `{function}`"
        raise BgError([bad_observable(text, reason, did_you_mean(function, FUNCTIONS))])
    wanted, argument = _arguments(match["inside"])
    _, _, kind, keeps_unit = _FUNCTIONS[function]
    if bool(kind) != bool(argument):
        reason = f"`{function}` takes {'a column and a ' + kind if kind else 'one column'}"
        raise BgError([bad_observable(text, reason)])
    start = read(match["start"], "from", "s") if match["start"] else 0.0
    end = read(match["end"], "to", "s") if match["end"] else float("inf")
    if not 0 <= start < end:
        raise BgError([bad_observable(text, "its part of the run has no length")])
    for column in columns_named(wanted, columns):
        unit, shown = columns[column]
        number = 0.0
        if kind:
            number = in_column_unit(argument, function, unit if kind == "level" else "", read)
        if kind == "share" and not 0 <= number <= 1:
            raise BgError([bad_observable(text, "a quantile lies between 0 and 1")])
        inside = ", ".join(filter(None, (name_in_si(column), argument)))
        name = f"{function}({inside}){text[match.end('inside') + 1 :]}"
        yield Observable(
            name, function, column, number, start, end,
            unit if keeps_unit else "1", shown if keeps_unit else _NUMBER,
        )  # fmt: skip


def in_column_unit(text: str, name: str, unit: str, read: Reader) -> float:
    """Read a number in the `unit` of a column, which is not SI where the scene observes it so.

    A number alone is in the unit of the column.
    """
    number = read(text, name, unit)
    return number / read(f"1 {unit}", name, unit) if unit and " " in text.strip() else number


def _arguments(inside: str) -> tuple[str, str]:
    """Split `M[1,2], 0.95` at the comma outside brackets."""
    depth = 0
    for place, character in enumerate(inside):
        depth += (character == "[") - (character == "]")
        if character == "," and depth == 0:
            return inside[:place].strip(), inside[place + 1 :].strip()
    return inside.strip(), ""


def columns_named(name: str, columns: Mapping[str, tuple[str, Shown]]) -> list[str]:
    """The columns of a name: itself, with the unit of its column, or the components of a vector."""
    in_si = {name_in_si(column): column for column in columns}
    for spelling in (name, column_of(name)):
        if spelling in columns:
            return [spelling]
        if spelling in in_si:
            return [in_si[spelling]]
    parts = [c for c in columns if name_in_si(component_of(c)[0]) == name]
    if not parts:
        raise BgError([unknown_column(name, columns)])
    return parts


@dataclass(frozen=True, slots=True)
class Reducer:
    """Computes observables from the rows of a run.

    `outputs` are the numbers of the observed outputs, which `column` finds in rows, (rows, width).
    Every `between`-th row is one of the scene, the others serve for extremes alone.
    """

    observables: tuple[Observable, ...]
    outputs: tuple[int, ...]
    column: Callable[[Array, int], Array]
    between: int = 1

    def __call__(self, time: Array, rows: Array) -> Array:
        """Reduce rows, (rows, width), to one number for each observable."""
        found = []
        for each, output in zip(self.observables, self.outputs, strict=True):
            some = slice(None, None, 1 if each.function in EXTREMES else self.between)
            found.append(each.of(time[some], self.column(rows[some], output)))
        return np.array(found)

    def gradients(self, time: Array, rows: Array) -> Array:
        """Derivatives of each observable by the values of its column, (observables, rows)."""
        found = np.zeros((len(self.observables), len(rows)))
        for k, (each, output) in enumerate(zip(self.observables, self.outputs, strict=True)):
            some = slice(None, None, 1 if each.function in EXTREMES else self.between)
            found[k, some] = each.gradient(time[some], self.column(rows[some], output))
        return found
