"""Headings around the hull: those of the data, and those that its symmetry adds."""

from __future__ import annotations

import numpy as np

from bgc.record_class import dataclass, replace
from bgc.runtime.importing.hydrodynamics.account import Account
from bgc.runtime.importing.hydrodynamics.checks import scales
from bgc.runtime.importing.hydrodynamics.record import Complex, Hull, Real

_SAME = 1e-3  # rad within which two headings are one
_SYMMETRIC = 2e-3  # share of the largest entry that a symmetric hull may have in a coupling
_WIDEST = np.pi / 3 + 1e-6  # rad over which forces are interpolated
_SIDES = np.array([1, -1, 1, -1, 1, -1.0])  # signs of the modes in a mirror along x
_ENDS = np.array([-1, 1, 1, 1, -1, -1.0])  # in a mirror along y


@dataclass(frozen=True, slots=True)
class Arc:
    """Headings between which forces are interpolated: from `first` over `width` (rad)."""

    first: float
    width: float

    @property
    def text(self) -> str:
        """The range in degrees, or the single heading."""
        low, high = np.degrees([self.first, self.first + self.width])
        return f"{low:.4g} to {high:.4g}" if self.width else f"{low:.4g}"


def around(hull: Hull, account: Account) -> Hull:
    """Sort the headings within a turn, and add those of a mirrored hull where it is symmetric.

    Crest and origin of the hull have to be one point; symmetry is judged about it.
    """
    hull = _sorted(hull)
    for signs, half, name in (
        (_SIDES, 0.0, "port and starboard"),
        (_ENDS, np.pi, "bow and stern"),
    ):
        image = (half - hull.heading) % (2 * np.pi)
        apart = np.abs((image[:, None] - hull.heading + np.pi) % (2 * np.pi) - np.pi)
        new = apart.min(axis=1) > _SAME
        gap = np.diff(np.append(hull.heading, hull.heading[0] + 2 * np.pi)).max()
        if (
            not new.any()
            or (gap <= _WIDEST and signs is _ENDS)
            or not _symmetric(hull, signs, apart)
        ):
            continue
        account.read(f"headings of the mirrored hull: {name} are symmetric")

        def both(m: Complex | None, new: Real = new, signs: Real = signs) -> Complex | None:
            return None if m is None else np.concatenate([m, m[:, new] * signs], axis=1)

        hull = _sorted(
            replace(
                hull,
                heading=np.concatenate([hull.heading, image[new]]),
                force=np.concatenate([hull.force, hull.force[:, new] * signs], axis=1),
                haskind=both(hull.haskind),
                motion=both(hull.motion),
            )
        )
    return hull


def covered(hull: Hull) -> tuple[Arc, ...]:
    """Return the arcs that sorted headings cover, in order; none for the whole turn."""
    steps = np.diff(np.append(hull.heading, hull.heading[0] + 2 * np.pi))
    ends = np.flatnonzero(steps > _WIDEST)
    arcs = []
    for before, end in zip(np.roll(ends, 1), ends, strict=True):
        first = hull.heading[(before + 1) % len(steps)]
        arcs.append(Arc(float(first), float((hull.heading[end] - first) % (2 * np.pi))))
    return tuple(sorted(arcs, key=lambda arc: arc.first))


def _sorted(hull: Hull) -> Hull:
    turned = hull.heading % (2 * np.pi)
    turned[2 * np.pi - turned < _SAME] = 0.0
    order = np.argsort(turned, kind="stable")
    order = order[np.append(True, np.diff(turned[order]) > _SAME)]

    def rows(m: Complex | None) -> Complex | None:
        return None if m is None else m[:, order]

    return replace(
        hull,
        heading=turned[order],
        force=hull.force[:, order],
        haskind=rows(hull.haskind),
        motion=rows(hull.motion),
    )


def _symmetric(hull: Hull, signs: Real, apart: Real) -> bool:
    """Judge by the couplings between even and odd modes, and the forces that have an image."""
    scale = scales(hull)
    odd = np.not_equal.outer(signs, signs)
    scaled = np.abs(hull.added_mass) / np.outer(scale, scale)
    if scaled[:, odd].max() > _SYMMETRIC * scaled.max():
        return False
    if hull.stiffness is not None:
        stiffness = np.abs(hull.stiffness) / np.outer(scale, scale)
        if stiffness[odd].max() > _SYMMETRIC * stiffness.max():
            return False
    here, there = np.nonzero(apart < _SAME)
    off = np.abs(hull.force[:, here] * signs - hull.force[:, there]) / scale
    return bool(off.size == 0 or off.max() <= 5 * _SYMMETRIC * (np.abs(hull.force) / scale).max())
