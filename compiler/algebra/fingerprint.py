"""Fingerprints: every node evaluated modulo two large primes, at a random point each.

Both residues are kept as one number modulo the product of the primes. Sums, products and quotients
are computed once for both, everything else for each.

Two nodes that are equal as rational functions of their symbols have equal fingerprints; two that
are not have equal ones with a probability of about their degree in 2^61. This decides "is zero",
"is constant" and "are equal" without a simplifier, in time linear in the number of nodes.

Trigonometric and hyperbolic functions and `exp` are evaluated at a random point of their conic, so
that `sin^2 + cos^2 = 1`, `tan = sin/cos`, `exp(-x) exp(x) = 1` and the parities hold. Modulo these
primes all small numbers have square roots, so that products and squares of roots of rational
constants are right: an axis `[1, -4, -1]/norm([1, -4, -1])` is recognised as a unit vector. All
other functions are hashes of their operands, and identities between them (`sqrt(x)^2 = x`) are not
recognised. A positive answer is therefore reliable; a negative one means "not proven".
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import lru_cache
from math import isqrt

from bgc.algebra.dag import Dag, Level, Op
from bgc.algebra.operation import Parity
from bgc.algebra.operations import ROWS
from bgc.algebra.residues import inverse_of_residues
from bgc.record_class import dataclass

# Each prime q up to 149 is a square modulo both (by quadratic reciprocity, with both 7 modulo 8).
# One prime in 2^35 has this property; these are two just below 2^61.
PRIME = 1_739_249_131_751_026_871
_OTHER_PRIME = 1_947_198_889_117_256_519  # modulo the first alone, PRIME + 1 is 1
_MODULUS = PRIME * _OTHER_PRIME
_STEP = PRIME * pow(PRIME, -1, _OTHER_PRIME)  # 0 modulo the first and 1 modulo the other
_MASK = 2**64 - 1
_LARGEST_RATIONAL = 2**29  # numerators and denominators below it are recovered uniquely
_REMEMBERED = 2**15  # results of functions: passes evaluate the same ones on graphs of their own
_SMALL_PRIMES = tuple(q for q in range(2, 150) if all(q % k for k in range(2, isqrt(q) + 1)))

# As plain ints: comparing with a member of an enumeration takes several times longer.
_CONST, _SYMBOL, _ADD, _SUB, _MUL, _DIV, _NEG, _SELECT, _SQRT = map(
    int, (Op.CONST, Op.SYMBOL, Op.ADD, Op.SUB, Op.MUL, Op.DIV, Op.NEG, Op.SELECT, Op.SQRT)
)
_INVERTED = int(Op.INVERTED)


class Fingerprints:
    """The fingerprints of the nodes of a DAG, which may grow; each node is visited once."""

    def __init__(self, dag: Dag) -> None:
        self.dag = dag
        self._values: list[int] = []
        self._steady: dict[int, int] = {}  # fingerprint -> node of at most PARAM level
        self._searched = 0
        self._inverses: dict[int, list[int] | None] = {}  # end of a list -> entries of the inverse

    def value(self, node: int) -> int:
        """The fingerprint of a node: its residues modulo both primes, as one modulo both."""
        if node >= len(self._values):
            self._extend()
        return self._values[node]

    def residue(self, node: int) -> int:
        """The residue of a node modulo `PRIME`."""
        return self.value(node) % PRIME

    def values(self) -> list[int]:
        """The fingerprints of all nodes of the DAG as it is now."""
        self._extend()
        return self._values.copy()

    def is_zero(self, node: int) -> bool:
        """Test whether a node is zero for all values of its symbols."""
        return self.value(node) == 0

    def equal(self, a: int, b: int) -> bool:
        """Test whether two nodes are equal for all values of their symbols."""
        return a == b or self.value(a) == self.value(b)

    def inverse(self, entries: Sequence[int]) -> list[int] | None:
        """The fingerprints of the inverse of a square matrix of nodes, given and returned by rows.

        None if it is singular for all values of its symbols.
        """
        values = [self.value(node) for node in entries]
        return inverse_of_residues(values, _MODULUS)

    def constant(self, node: int) -> Fraction | None:
        """The rational number that a node always equals; None if none is proven."""
        exact = self.dag.value(node)
        if exact is not None:
            return exact
        value = self.value(node)
        found = _rational(value % PRIME)
        # More than half of all residues belong to some small fraction; only the right fraction
        # has the right residue modulo the other prime too.
        return found if found is not None and _residue(found, _MODULUS) == value else None

    def simplified(self, node: int) -> int:
        """Find an equal node that changes less often; without one, return the node itself.

        It is a number, or an expression of constants and parameters that the DAG already holds:
        `cos(x) (c cos(x)) + sin(x) (c sin(x))` becomes c, even if c is not a simple fraction.
        """
        dag = self.dag
        exact = self.constant(node)
        if exact is not None:
            return dag.const(exact)
        if dag.level[node] <= Level.PARAM:
            return node
        for known in range(self._searched, len(dag)):
            if dag.level[known] <= Level.PARAM:
                self._steady.setdefault(self.value(known), known)
        self._searched = len(dag)
        value = self.value(node)
        if (same := self._steady.get(value)) is not None:
            return same
        opposite = self._steady.get(negative(value))
        return node if opposite is None else dag.neg(opposite)

    def _extend(self) -> None:
        dag, values = self.dag, self._values
        op, a, b, c = dag.op, dag.a, dag.b, dag.c
        for node in range(len(values), len(dag)):
            kind = op[node]
            if kind == _MUL:
                result = values[a[node]] * values[b[node]] % _MODULUS
            elif kind == _ADD:
                result = values[a[node]] + values[b[node]]
                if result >= _MODULUS:
                    result -= _MODULUS
            elif kind == _SUB:
                result = values[a[node]] - values[b[node]]
                if result < 0:
                    result += _MODULUS
            elif kind == _NEG:
                result = negative(values[a[node]])
            elif kind == _CONST:
                result = _residue(dag.constants[a[node]], _MODULUS)
            elif kind == _SYMBOL:
                symbol = dag.symbols[a[node]]
                result = _at_both(_Point.hashed, kind, symbol.kind + 1, symbol.index + 1)
            elif kind == _SELECT:
                condition, yes, no = values[a[node]], values[b[node]], values[c[node]]
                weight = _at_both(_Point.weight, kind, condition)
                result = (no + weight * (yes - no)) % _MODULUS
            elif kind == _SQRT and op[a[node]] == _CONST:
                result = _root(dag.constants[a[a[node]]], values[a[node]])
            elif kind == _DIV:
                result = _divided(values[a[node]], values[b[node]])
            elif kind == _INVERTED:
                result = self._of_inverse(node)
            elif c[node] >= 0:
                operands = (values[a[node]], values[b[node]], values[c[node]])
                result = _at_both(_Point.hashed, kind, *operands)
            elif b[node] >= 0:
                result = _at_both(_Point.of_two, kind, values[a[node]], values[b[node]])
            else:
                result = _at_both(_Point.of_one, kind, values[a[node]])
            values.append(result)

    def _of_inverse(self, node: int) -> int:
        """The fingerprint of an entry of an inverse; a hash where the matrix is singular."""
        listed = self.dag.a[node]
        if listed not in self._inverses:
            self._inverses[listed] = self.inverse(self.dag.listed(listed))
        entries = self._inverses[listed]
        if entries is not None:
            return entries[self.dag.place_in_inverse(node)]
        return _at_both(
            _Point.of_two, _INVERTED, *map(self._values.__getitem__, self.dag.operands(node))
        )


def negative(value: int) -> int:
    """The fingerprint of the opposite of a node."""
    return _MODULUS - value if value else 0


@dataclass(frozen=True, slots=True)
class _Point:
    """A random point, modulo a prime."""

    seed: int
    prime: int

    def of_two(self, op: int, x: int, y: int) -> int:
        if op == _DIV:
            return x * pow(y, -1, self.prime) % self.prime if y else self.hashed(op, x)
        if ROWS[op].symmetric:
            x, y = min(x, y), max(x, y)
        return self.hashed(op, x, y)

    def of_one(self, op: int, x: int) -> int:
        row = ROWS[op]
        if x == 0 and (exact := row.folded([Fraction(0)])) is not None:
            return _residue(Fraction(exact), self.prime)
        if row.curve is not None:
            dividend, divisor = row.curve.point(self._odd(row.curve.conic, x))
            return (
                dividend * pow(divisor, -1, self.prime) % self.prime if divisor % self.prime else 1
            )
        if row.parity is Parity.ODD:
            return self._odd(op, x)
        if row.parity is Parity.EVEN:
            return self.hashed(op, min(x, self.prime - x))
        return self.hashed(op, x)

    def weight(self, op: int, condition: int) -> int:
        """The weight of the first branch of a choice; zero if the condition is always zero."""
        return self.hashed(op, condition) if condition else 0

    def _odd(self, op: int, x: int) -> int:
        """A hash with f(-x) = -f(x)."""
        if x == 0:
            return 0
        opposite = self.prime - x
        return self.hashed(op, x) if x < opposite else self.prime - self.hashed(op, opposite)

    def hashed(self, op: int, *words: int) -> int:
        """A well mixed residue, never zero (splitmix64 over the words)."""
        state = self.seed
        for word in (op, *words):
            state = (state ^ word) + 0x9E3779B97F4A7C15 & _MASK
            state = (state ^ state >> 30) * 0xBF58476D1CE4E5B9 & _MASK
            state = (state ^ state >> 27) * 0x94D049BB133111EB & _MASK
            state ^= state >> 31
        return state % (self.prime - 1) + 1


_POINT, _OTHER_POINT = _Point(1, PRIME), _Point(2, _OTHER_PRIME)


@lru_cache(_REMEMBERED)
def _at_both(function: Callable[..., int], op: int, *operands: int) -> int:
    """Evaluate a function of an operation and residues at both points, and join the results."""
    return _joined(
        function(_POINT, op, *(x % PRIME for x in operands)),
        function(_OTHER_POINT, op, *(x % _OTHER_PRIME for x in operands)),
    )


def _joined(first: int, other: int) -> int:
    """The number modulo the product of both primes (Chinese remainder theorem)."""
    return (first + _STEP * (other - first)) % _MODULUS


@lru_cache(_REMEMBERED)
def _divided(x: int, y: int) -> int:
    """A quotient; a hash where the divisor is zero."""
    try:
        return x * pow(y, -1, _MODULUS) % _MODULUS
    except ValueError:  # zero modulo one of the primes
        return _at_both(_Point.of_two, _DIV, x, y)


def _root(square: Fraction, value: int) -> int:
    """The square root of a rational number from the roots of its prime factors, else a hash."""
    factors = _square_free(square)
    if factors is None:
        return _at_both(_Point.hashed, _SQRT, value)
    outside, primes = factors
    root = _residue(outside, _MODULUS)
    for prime in primes:
        first, other = (pow(prime, (p + 1) // 4, p) for p in (PRIME, _OTHER_PRIME))
        root = root * _joined(first, other) % _MODULUS
    return root


def _residue(exact: Fraction, modulus: int) -> int:
    if exact.denominator == 1:
        return exact.numerator % modulus
    return exact.numerator * pow(exact.denominator, -1, modulus) % modulus


def _square_free(square: Fraction) -> tuple[Fraction, tuple[int, ...]] | None:
    """Split sqrt(square) into a fraction and square roots of distinct small primes, if possible."""
    left = square.numerator * square.denominator
    if left <= 0:
        return None
    outside, primes = 1, []
    for prime in _SMALL_PRIMES:  # they have square roots modulo both
        count = 0
        while left % prime == 0:
            left //= prime
            count += 1
        outside *= prime ** (count // 2)
        if count % 2:
            primes.append(prime)
    rest = isqrt(left)
    if rest * rest != left:
        return None
    return Fraction(outside * rest, square.denominator), tuple(primes)


def _rational(residue: int) -> Fraction | None:
    """The fraction with small numerator and denominator that has this residue, if any.

    Rational reconstruction by the extended Euclidean algorithm.
    """
    r0, r1, t0, t1 = PRIME, residue, 0, 1
    while r1 >= _LARGEST_RATIONAL:
        quotient = r0 // r1
        r0, r1, t0, t1 = r1, r0 - quotient * r1, t1, t0 - quotient * t1
    if t1 == 0 or abs(t1) >= _LARGEST_RATIONAL:
        return None
    return Fraction(r1, t1)
