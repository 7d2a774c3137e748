"""Faces: the places where wide bonds meet elements and ports, with their widths and domains."""

from __future__ import annotations

from dataclasses import dataclass, field

from bgc.algebra.disjoint_sets import Joined
from bgc.diagnostics.source import Span
from bgc.grammar import syntax
from bgc.resolution.modules import Declared


@dataclass(frozen=True, slots=True)
class Width:
    """A known width, and the place that says so."""

    size: int
    span: Span
    explicit: bool  # written in brackets, or a domain's: even a width of 1 is then a vector


@dataclass(frozen=True, slots=True)
class DomainUse:
    """A domain, and the place that says so."""

    declared: Declared[syntax.Domain]
    span: Span


@dataclass(slots=True, eq=False)
class Net(Joined):
    """Faces and bonds of one width and one domain, joined by junctions and ports."""

    width: Width | None = None
    domain: DomainUse | None = None


@dataclass(slots=True, eq=False)
class Face:
    """Where bonds meet something.

    Every bond at a junction has its full width; at any other face the widths of its bonds add
    up, in the order written, to the width of the face.
    """

    name: str
    span: Span
    junction: bool
    net: Net = field(default_factory=Net)
    joints: list[Joint] = field(default_factory=list)


@dataclass(slots=True, eq=False)
class Joint:
    """One end of a wide bond. `slice` is the part of the face it takes, None for all of it.

    `at` are the components of the face (from 0) that the bond's components meet, once known.
    """

    face: Face
    bond: WideBond
    is_head: bool
    slice: tuple[int, ...] | None
    span: Span
    at: tuple[int, ...] = ()

    @property
    def other(self) -> Joint:
        """The bond's other end."""
        return self.bond.tail if self.is_head else self.bond.head


@dataclass(slots=True, eq=False)
class WideBond:
    """A bond as written, of any width: one arrow of a chain."""

    name: str
    span: Span
    net: Net
    ends: list[Joint] = field(default_factory=list)

    @property
    def tail(self) -> Joint:
        """Where the half arrow starts."""
        return self.ends[0]

    @property
    def head(self) -> Joint:
        """Where the half arrow points."""
        return self.ends[1]
