"""Numbers for nodes: plain double arithmetic over the DAG, with C's results at the edges."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction

from bgc.algebra.dag import Dag, Op, Symbol


def evaluate_nodes(
    dag: Dag, roots: Iterable[int], leaf_values: Mapping[Symbol, float]
) -> list[float]:
    """The values of the roots for given values of the symbols they need.

    Time is linear in the number of nodes reached. Nothing raises at the edges of arithmetic:
    as in C, `1/0` is infinite and `log(-1)` is not a number.

    Raises
    ------
    KeyError
        A symbol that the roots need has no value.
    """
    roots = list(roots)
    done: dict[int, float] = {}
    for node in dag.reachable(roots):
        exact, symbol = dag.value(node), dag.symbol_of(node)
        if exact is not None:
            done[node] = to_double(exact)
        elif symbol is not None:
            done[node] = leaf_values[symbol]
        else:
            done[node] = apply(Op(dag.op[node]), *(done[x] for x in dag.operands(node)))
    return [done[root] for root in roots]


class Evaluator:
    """The values of a graph's nodes at one point, each node visited once however often asked.

    `leaf` gives the value of a symbol; it is asked once for each.
    """

    def __init__(self, dag: Dag, leaf: Callable[[Symbol], float]) -> None:
        self._dag = dag
        self._leaf = leaf
        self._known: dict[int, float] = {}

    def value(self, node: int) -> float:
        """The value of a node."""
        known, dag = self._known, self._dag
        stack = [node]
        while stack:
            top = stack[-1]
            missing = [x for x in dag.operands(top) if x not in known] if top not in known else ()
            if missing:
                stack.extend(missing)
                continue
            stack.pop()
            if top not in known:
                known[top] = self._made(top)
        return known[node]

    def _made(self, node: int) -> float:
        dag = self._dag
        exact, symbol = dag.value(node), dag.symbol_of(node)
        if exact is not None:
            return to_double(exact)
        if symbol is not None:
            return self._leaf(symbol)
        return apply(Op(dag.op[node]), *(self._known[x] for x in dag.operands(node)))


def to_double(exact: Fraction) -> float:
    """The nearest double, infinite beyond the largest."""
    try:
        return float(exact)
    except OverflowError:
        return math.inf if exact > 0 else -math.inf


def apply(op: Op, *operands: float) -> float:
    """One operation on doubles, with C's results."""
    return _OPERATIONS[op](*operands)


def _divide(x: float, y: float) -> float:
    if y != 0:
        return x / y
    return math.nan if x == 0 or math.isnan(x) else math.copysign(math.inf, x) * _sign_of(y)


def _sign_of(x: float) -> float:
    return math.copysign(1.0, x)


def _power(x: float, y: float) -> float:
    try:
        return math.pow(x, y)
    except OverflowError:
        odd = y == math.floor(y) and math.fmod(y, 2) != 0
        return -math.inf if x < 0 and odd else math.inf
    except ValueError:  # a root of a negative number, or zero to a negative power
        return math.nan if x < 0 else math.inf


def _sign(x: float) -> float:
    return x if math.isnan(x) else float((x > 0) - (x < 0))


def _smaller(x: float, y: float) -> float:
    return y if math.isnan(x) or y < x else x


def _larger(x: float, y: float) -> float:
    return y if math.isnan(x) or y > x else x


def _with_limits(
    function: Callable[[float], float], overflow: Callable[[float], float], *poles: float
) -> Callable[[float], float]:
    """C's version of a function of Python: infinite where it overflows and at its poles."""

    def of(x: float) -> float:
        try:
            return function(x)
        except OverflowError:
            return overflow(x)
        except ValueError:
            return overflow(x) if x in poles else math.nan

    return of


def _upwards(x: float) -> float:
    return math.inf


def _downwards(x: float) -> float:
    return -math.inf


def _outwards(x: float) -> float:
    return math.copysign(math.inf, x)


def _truth(holds: bool, *operands: float) -> float:
    """Undefined where an operand is; only a single `x == x` asks whether it is (`switches`)."""
    return math.nan if any(map(math.isnan, operands)) else float(holds)


def _rounding(function: Callable[[float], int]) -> Callable[[float], float]:
    return lambda x: float(function(x)) if math.isfinite(x) else x


def _fmod(x: float, y: float) -> float:
    return math.nan if y == 0 or math.isinf(x) else math.fmod(x, y)


_OPERATIONS: Mapping[Op, Callable[..., float]] = {
    Op.ADD: lambda x, y: x + y,
    Op.SUB: lambda x, y: x - y,
    Op.MUL: lambda x, y: x * y,
    Op.DIV: _divide,
    Op.NEG: lambda x: -x,
    Op.POW: _power,
    Op.SELECT: lambda c, yes, no: no if c == 0 else yes if c == c else c,
    Op.LT: lambda x, y: _truth(x < y, x, y),
    Op.LE: lambda x, y: _truth(x <= y, x, y),
    Op.EQ: lambda x, y: 0.0 if x != x and y != y else _truth(x == y, x, y),
    Op.AND: lambda x, y: 0.0 if x == 0 or y == 0 else _truth(True, x, y),
    Op.OR: lambda x, y: 1.0 if x < 0 or x > 0 or y < 0 or y > 0 else x + y,
    Op.NOT: lambda x: _truth(x == 0, x),
    Op.SIN: _with_limits(math.sin, _outwards),
    Op.COS: _with_limits(math.cos, _outwards),
    Op.TAN: _with_limits(math.tan, _outwards),
    Op.ASIN: _with_limits(math.asin, _outwards),
    Op.ACOS: _with_limits(math.acos, _outwards),
    Op.ATAN: math.atan,
    Op.ATAN2: math.atan2,
    Op.SINH: _with_limits(math.sinh, _outwards),
    Op.COSH: _with_limits(math.cosh, _upwards),
    Op.TANH: math.tanh,
    Op.ASINH: math.asinh,
    Op.ACOSH: _with_limits(math.acosh, _upwards),
    Op.ATANH: _with_limits(math.atanh, _outwards, -1.0, 1.0),
    Op.EXP: _with_limits(math.exp, _upwards),
    Op.EXPM1: _with_limits(math.expm1, _upwards),
    Op.LOG: _with_limits(math.log, _downwards, 0.0),
    Op.LOG10: _with_limits(math.log10, _downwards, 0.0),
    Op.LOG1P: _with_limits(math.log1p, _downwards, -1.0),
    Op.SQRT: _with_limits(math.sqrt, _upwards),
    Op.CBRT: math.cbrt,
    Op.ABS: abs,
    Op.SIGN: _sign,
    Op.MIN: _smaller,
    Op.MAX: _larger,
    Op.FLOOR: _rounding(math.floor),
    Op.CEIL: _rounding(math.ceil),
    Op.FMOD: _fmod,
    Op.HYPOT: math.hypot,
    Op.ERF: math.erf,
}
