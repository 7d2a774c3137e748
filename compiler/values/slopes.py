"""Slopes at the knots of cubic interpolants, with NumPy; values may have further axes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy.typing import NDArray

_CONVERGED = 2.0**-60  # of neighbours in a tridiagonal system, over the diagonal


def pchip_slopes(x: NDArray[Any], y: NDArray[Any], repeat: bool) -> NDArray[Any]:
    """Slopes of the monotone cubic of Fritsch and Butland.

    Each is the weighted harmonic mean of those of the chords on both sides, zero where these have
    different signs (F. N. Fritsch, J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300). At the
    ends a parabola through three points, limited so that it does not overshoot; with `repeat`, the
    last chord comes before the first.
    """
    import numpy as np  # takes longer to load than most models to compile

    h, chord = _chords(x, y)
    if repeat:
        h = np.concatenate((h[-1:], h, h[:1]))
        chord = np.concatenate((chord[-1:], chord, chord[:1]))
    before, after = chord[:-1], chord[1:]
    first, second = 2 * h[1:] + h[:-1], h[1:] + 2 * h[:-1]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        mean = (first + second) / (first / before + second / after)
    inner = np.where(np.sign(before) * np.sign(after) > 0, mean, 0.0)
    if repeat:
        return inner
    if len(x) == 2:
        return np.concatenate((chord, chord))
    ends = (
        _pchip_end(h[0], h[1], chord[0], chord[1]),
        _pchip_end(h[-1], h[-2], chord[-1], chord[-2]),
    )
    return np.concatenate((ends[0][None], inner, ends[1][None]))


def _pchip_end(h: Any, further: Any, chord: Any, next_chord: Any) -> Any:
    import numpy as np

    slope = ((2 * h + further) * chord - h * next_chord) / (h + further)
    slope = np.where(np.sign(slope) != np.sign(chord), 0.0, slope)
    limited = (np.sign(chord) != np.sign(next_chord)) & (np.abs(slope) > 3 * np.abs(chord))
    return np.where(limited, 3 * chord, slope)


def spline_slopes(x: NDArray[Any], y: NDArray[Any], repeat: bool) -> NDArray[Any]:
    """Slopes of the cubic spline with continuous second derivatives.

    At the ends the third derivative is continuous at the second knot ("not a knot"): three knots
    give a parabola, two a line. With `repeat` the spline is periodic.
    """
    import numpy as np

    h, chord = _chords(x, y)
    if len(x) == 2:
        return np.concatenate((chord, chord))
    if repeat:
        before, chord_before = np.roll(h, 1, 0), np.roll(chord, 1, 0)
        right = 3 * (h * chord_before + before * chord)
        inner = _solve(h, 2 * (h + before), before, right)
        return np.concatenate((inner, inner[:1]))
    if len(x) == 3:
        bend = (chord[1] - chord[0]) / (h[0] + h[1])
        return np.stack((chord[0] - h[0] * bend, chord[0] + h[0] * bend, chord[1] + h[1] * bend))
    right = 3 * (h[1:] * chord[:-1] + h[:-1] * chord[1:])
    below, above, diagonal = h[1:].copy(), h[:-1].copy(), 2 * (h[1:] + h[:-1])
    low, high = h[0] + h[1], h[-1] + h[-2]
    first = ((h[0] + 2 * low) * h[1] * chord[0] + h[0] ** 2 * chord[1]) / low
    last = ((h[-1] + 2 * high) * h[-2] * chord[-1] + h[-1] ** 2 * chord[-2]) / high
    right[0] -= first  # the slopes at the ends are eliminated
    right[-1] -= last
    diagonal[0] -= low
    diagonal[-1] -= high
    below[0] = above[-1] = 0.0
    inner = _solve(below, diagonal, above, right)
    ends = (first - low * inner[0]) / h[1], (last - high * inner[-1]) / h[-2]
    return np.concatenate((ends[0][None], inner, ends[1][None]))


def _chords(x: NDArray[Any], y: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Lengths of the intervals, shaped as the values, and slopes of their chords."""
    import numpy as np

    h = np.diff(x).reshape((-1,) + (1,) * (y.ndim - 1))
    return h, np.diff(y, axis=0) / h


def _solve(a: NDArray[Any], b: NDArray[Any], c: NDArray[Any], r: NDArray[Any]) -> NDArray[Any]:
    """Solve `a[i] x[i-1] + b[i] x[i] + c[i] x[i+1] = r[i]`, cyclic in i, diagonally dominant.

    Parallel cyclic reduction (R. W. Hockney, C. R. Jesshope, Parallel Computers, 1981): each round
    eliminates the neighbours by equations twice as far away, until what is left is negligible.
    """
    import numpy as np

    step = 1
    while np.any(np.abs(a) + np.abs(c) > _CONVERGED * np.abs(b)):
        lower, upper = -a / np.roll(b, step, 0), -c / np.roll(b, -step, 0)
        b = b + lower * np.roll(c, step, 0) + upper * np.roll(a, -step, 0)
        r = r + lower * np.roll(r, step, 0) + upper * np.roll(r, -step, 0)
        a, c = lower * np.roll(a, step, 0), upper * np.roll(c, -step, 0)
        step *= 2
    found: NDArray[Any] = r / b
    return found
