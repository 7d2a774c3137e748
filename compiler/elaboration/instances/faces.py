"""Faces, where wide bonds are attached to elements and ports, with their widths and domains."""

from __future__ import annotations

from bgc.algebra.disjoint_sets import Joined
from bgc.diagnostics.source import Span
from bgc.grammar import syntax
from bgc.record_class import dataclass, field
from bgc.resolution.modules import Declared


@dataclass(frozen=True, slots=True)
class Width:
    """A known width and the source location that implies it."""

    size: int
    span: Span
    explicit: bool  # from brackets, which make a vector of a width of 1 too


@dataclass(frozen=True, slots=True)
class DomainUse:
    """A domain and the source location that names it."""

    declared: Declared[syntax.Domain]
    span: Span


@dataclass(slots=True, eq=False)
class Net(Joined):
    """Faces and bonds of one width and one domain, joined by junctions and ports."""

    width: Width | None = None
    domain: DomainUse | None = None


@dataclass(slots=True, eq=False)
class Face:
    """The place where bonds are attached to an element or to one side of a port.

    Every bond at a junction has the full width of its face. At any other face each bond takes some
    of the components: consecutive ones in the order written, unless it names a slice.
    """

    name: str
    span: Span
    junction: bool
    net: Net = field(default_factory=Net)
    joints: list[Joint] = field(default_factory=list)


@dataclass(slots=True, eq=False)
class Joint:
    """One end of a wide bond.

    `slice` lists the components of the face (from 0) that the source names, None without a slice.
    `at[k]` is the component of the face that component k of the bond joins; empty until widths are
    known.
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
    """A bond of any width, one arrow of a chain."""

    name: str
    span: Span
    net: Net
    ends: list[Joint] = field(default_factory=list)

    @property
    def tail(self) -> Joint:
        """The end where the half arrow starts."""
        return self.ends[0]

    @property
    def head(self) -> Joint:
        """The end to which the half arrow points."""
        return self.ends[1]
