"""Fingerprints: every node evaluated modulo two large primes, at a random point each.

Two nodes that are equal as rational functions of their symbols have equal fingerprints; two
that are not collide with a probability of about their degree in 2^61. So "is zero", "is
constant" and "equal" are told without a simplifier, in time linear in the number of nodes.

Trigonometric and hyperbolic functions and `exp` get a random point of their curve, hence
`sin^2 + cos^2 = 1`, `tan = sin/cos`, `exp(-x) exp(x) = 1` and the symmetries hold. The primes are
such that all small numbers have square roots modulo them: those of rational constants multiply
and square as they should, so that an axis `[1, -4, -1]/norm([1, -4, -1])` is known to have length
1. All other functions are hashes of their operands: identities among them (`sqrt(x)^2 = x`) are
not seen. An answer "zero", "constant" or "equal" can therefore be relied on, a "no" only means
"not proven".
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from math import isqrt

from bgc.algebra.dag import Dag, Level, Op

# Both are 7 modulo 8 and, with q up to 149, of a residue modulo q that makes each q a square
# (quadratic reciprocity): of such primes, each 2^-35 of all, two just below 2^61.
PRIME = 1_739_249_131_751_026_871
_PRIMES = (PRIME, 1_947_198_889_117_256_519)  # two: modulo the first alone, PRIME + 1 is 1
_MASK = 2**64 - 1
_LARGEST_RATIONAL = 2**29  # numerator and denominator below it are recovered uniquely
_LARGEST_ROOT = 149  # primes up to it have square roots modulo both


class Fingerprints:
    """The fingerprints of a DAG's nodes; they grow with the DAG, each node is visited once."""

    def __init__(self, dag: Dag) -> None:
        self.dag = dag
        self._points = [_Point(dag, seed, prime) for seed, prime in enumerate(_PRIMES, start=1)]
        self._steady: dict[tuple[int, ...], int] = {}  # nodes that no state or time moves
        self._looked_at = 0

    def value(self, node: int) -> tuple[int, ...]:
        """The residues of a node, one a point; the first is modulo `PRIME`."""
        return tuple(point.value(node) for point in self._points)

    def residues(self) -> list[tuple[int, ...]]:
        """The residues of all nodes there are now."""
        last = len(self.dag) - 1
        return list(zip(*(point.values_to(last) for point in self._points), strict=True))

    def is_zero(self, node: int) -> bool:
        """Whether a node is zero for all values of its symbols."""
        return all(point.value(node) == 0 for point in self._points)

    def equal(self, a: int, b: int) -> bool:
        """Whether two nodes are equal for all values of their symbols."""
        return a == b or all(point.value(a) == point.value(b) for point in self._points)

    def constant(self, node: int) -> Fraction | None:
        """The number that a node always equals; None if it varies or is no simple fraction."""
        exact = self.dag.value(node)
        if exact is not None:
            return exact
        first, *others = self.value(node)
        found = _rational(first)
        if found is None:
            return None
        # More than half of all residues are those of some fraction: only the right one has the
        # right residue modulo another prime too.
        rest = zip(others, _PRIMES[1:], strict=True)
        return found if all(other == _residue(found, prime) for other, prime in rest) else None

    def simplified(self, node: int) -> int:
        """A node that always equals this one and changes less often, if there is one.

        A number, or an expression of constants and parameters that is in the DAG already:
        `cos(x) (c cos(x)) + sin(x) (c sin(x))` is c, also where c is no simple fraction.
        """
        dag = self.dag
        exact = self.constant(node)
        if exact is not None:
            return dag.const(exact)
        if dag.level[node] <= Level.PARAM:
            return node
        for known in range(self._looked_at, len(dag)):
            if dag.level[known] <= Level.PARAM:
                self._steady.setdefault(self.value(known), known)
        self._looked_at = len(dag)
        residues = self.value(node)
        if (same := self._steady.get(residues)) is not None:
            return same
        opposite = self._steady.get(negative(residues))
        return node if opposite is None else dag.neg(opposite)


def negative(residues: tuple[int, ...]) -> tuple[int, ...]:
    """The residues of the opposite of a node."""
    return tuple(-x % prime for x, prime in zip(residues, _PRIMES, strict=True))


class _Point:
    """Residues of all nodes at one random point, modulo a prime."""

    def __init__(self, dag: Dag, seed: int, prime: int) -> None:
        self._dag = dag
        self._seed = seed
        self._prime = prime
        self._values: list[int] = []

    def value(self, node: int) -> int:
        if node >= len(self._values):
            self._extend()
        return self._values[node]

    def values_to(self, node: int) -> list[int]:
        """The residues of all nodes up to one, that one included."""
        self.value(node)
        return self._values[: node + 1]

    def _extend(self) -> None:
        dag, values, prime = self._dag, self._values, self._prime
        op, a, b, c = dag.op, dag.a, dag.b, dag.c
        for node in range(len(values), len(dag)):
            kind = op[node]
            if kind == Op.MUL:
                result = values[a[node]] * values[b[node]] % prime
            elif kind == Op.ADD:
                result = (values[a[node]] + values[b[node]]) % prime
            elif kind == Op.SUB:
                result = (values[a[node]] - values[b[node]]) % prime
            elif kind == Op.NEG:
                result = -values[a[node]] % prime
            elif kind == Op.CONST:
                result = _residue(dag.constants[a[node]], prime)
            elif kind == Op.SYMBOL:
                symbol = dag.symbols[a[node]]
                result = self._hash(kind, symbol.kind + 1, symbol.index + 1)
            elif kind == Op.SELECT:
                condition, yes, no = values[a[node]], values[b[node]], values[c[node]]
                weight = self._hash(kind, condition) if condition else 0
                result = (no + weight * (yes - no)) % prime
            elif kind == Op.SQRT and op[a[node]] == Op.CONST:
                result = self._root(dag.constants[a[a[node]]], values[a[node]])
            elif b[node] >= 0:
                result = self._of_two(kind, values[a[node]], values[b[node]])
            else:
                result = self._of_one(kind, values[a[node]])
            values.append(result)

    def _of_two(self, op: int, x: int, y: int) -> int:
        if op == Op.DIV:
            return x * pow(y, -1, self._prime) % self._prime if y else self._hash(op, x)
        if op in {Op.MIN, Op.MAX, Op.AND, Op.OR, Op.EQ, Op.HYPOT}:
            x, y = min(x, y), max(x, y)
        return self._hash(op, x, y)

    def _of_one(self, op: int, x: int) -> int:
        curve = _CURVES.get(Op(op))
        if curve is not None:
            family, function = curve
            return function(self._odd(family, x), self._prime)
        if op in _ODD:
            return self._odd(op, x)
        if op == Op.ABS:
            return self._hash(op, min(x, self._prime - x)) if x else 0
        return self._hash(op, x)

    def _root(self, square: Fraction, residue: int) -> int:
        """The square root of a number, of prime factors each to its own root; else a hash."""
        factors = _square_free(square)
        if factors is None:
            return self._hash(Op.SQRT, residue)
        outside, primes = factors
        root = _residue(outside, self._prime)
        for prime in primes:
            root = root * pow(prime, (self._prime + 1) // 4, self._prime) % self._prime
        return root

    def _odd(self, op: int, x: int) -> int:
        """A hash with f(-x) = -f(x)."""
        if x == 0:
            return 0
        opposite = self._prime - x
        return self._hash(op, x) if x < opposite else self._prime - self._hash(op, opposite)

    def _hash(self, op: int, *words: int) -> int:
        """A well mixed residue, never zero (splitmix64 over the words)."""
        state = self._seed
        for word in (op, *words):
            state = (state ^ word) + 0x9E3779B97F4A7C15 & _MASK
            state = (state ^ state >> 30) * 0xBF58476D1CE4E5B9 & _MASK
            state = (state ^ state >> 27) * 0x94D049BB133111EB & _MASK
            state ^= state >> 31
        return state % (self._prime - 1) + 1


def _residue(exact: Fraction, prime: int) -> int:
    if exact.denominator == 1:
        return exact.numerator % prime
    return exact.numerator * pow(exact.denominator, -1, prime) % prime


def _square_free(square: Fraction) -> tuple[Fraction, tuple[int, ...]] | None:
    """The root of a number as a fraction times the roots of small primes, each once, if it is."""
    left = square.numerator * square.denominator
    if left <= 0:
        return None
    outside, primes = Fraction(1, square.denominator), []
    for factor in (2, *range(3, _LARGEST_ROOT + 1, 2)):  # what is not prime no longer divides
        count = 0
        while left % factor == 0:
            left //= factor
            count += 1
        outside *= factor ** (count // 2)
        if count % 2:
            primes.append(factor)
    rest = isqrt(left)
    return (outside * rest, tuple(primes)) if rest * rest == left else None


def _rational(residue: int) -> Fraction | None:
    """The fraction with small numerator and denominator that has this residue, if any."""
    r0, r1, t0, t1 = PRIME, residue, 0, 1
    while r1 >= _LARGEST_RATIONAL:
        quotient = r0 // r1
        r0, r1, t0, t1 = r1, r0 - quotient * r1, t1, t0 - quotient * t1
    if t1 == 0 or abs(t1) >= _LARGEST_RATIONAL:
        return None
    return Fraction(r1, t1)


def _quotient(x: int, y: int, prime: int) -> int:
    return x * pow(y, -1, prime) % prime if y % prime else 1


# Functions of a rational parameter t of the circle and of the hyperbola, odd in the argument.
_CIRCLE, _HYPERBOLA = 101, 102
_CURVES: dict[Op, tuple[int, Callable[[int, int], int]]] = {
    Op.SIN: (_CIRCLE, lambda t, p: _quotient(2 * t, 1 + t * t, p)),
    Op.COS: (_CIRCLE, lambda t, p: _quotient(1 - t * t, 1 + t * t, p)),
    Op.TAN: (_CIRCLE, lambda t, p: _quotient(2 * t, 1 - t * t, p)),
    Op.SINH: (_HYPERBOLA, lambda t, p: _quotient(2 * t, 1 - t * t, p)),
    Op.COSH: (_HYPERBOLA, lambda t, p: _quotient(1 + t * t, 1 - t * t, p)),
    Op.TANH: (_HYPERBOLA, lambda t, p: _quotient(2 * t, 1 + t * t, p)),
    Op.EXP: (_HYPERBOLA, lambda t, p: _quotient(1 + t, 1 - t, p)),
    Op.EXPM1: (_HYPERBOLA, lambda t, p: _quotient(2 * t, 1 - t, p)),
}
_ODD = frozenset({Op.ASIN, Op.ATAN, Op.ASINH, Op.ATANH, Op.CBRT, Op.ERF, Op.SIGN})
