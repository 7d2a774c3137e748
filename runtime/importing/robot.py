"""A robot as its description gives it: links and joints, in SI units.

The tree is in depth-first order, the root first. Joints belong to their child link.
"""

from __future__ import annotations

from enum import Enum
from pathlib import Path

from bgc.diagnostics.source import Span
from bgc.record_class import dataclass, field
from bgc.runtime.importing.rotation_text import UNTURNED, Rotation, Vector

ORIGIN: Vector = (0.0, 0.0, 0.0)


class Kind(Enum):
    """Kinds of joints; the value is the word for a comment."""

    FIXED = "fixed"
    TURNS = "revolute"
    SLIDES = "prismatic"
    FLOATS = "floating"
    PLANAR = "planar"
    BALL = "ball"

    @property
    def driven(self) -> bool:
        """True for a joint with one coordinate, which a shaft can drive."""
        return self in (Kind.TURNS, Kind.SLIDES)


@dataclass(frozen=True, slots=True)
class Pose:
    """A frame in another one: its origin, and its axes."""

    origin: Vector = ORIGIN
    axes: Rotation = UNTURNED


@dataclass(frozen=True, slots=True)
class Body:
    """Mass properties: centre of mass and inertia tensor about it, in the axes of the link."""

    mass: float
    com: Vector
    inertia: tuple[Vector, Vector, Vector]
    span: Span | None = None


@dataclass(frozen=True, slots=True)
class Picture:
    """A shape of a link: `box` (three lengths), `cylinder`, `capsule`, `sphere` or `mesh`."""

    kind: str
    sizes: tuple[float, ...]
    pose: Pose
    colour: str = ""
    file: Path | None = None


@dataclass(frozen=True, slots=True)
class Mimicked:
    """A joint that follows: coordinate = `ratio` times that of `leader` + `offset`."""

    leader: str
    ratio: float
    offset: float


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint between `parent` and `child`, links by name.

    `place` is the frame of the joint in that of the parent; `after` the origin of the child in the
    joint's frame, which turns with it. `lower` and `upper` are None without limits. `damping` is
    viscous, `friction` dry, `rotor` an inertia on the coordinate. A spring rests at `relaxed`.
    """

    name: str
    kind: Kind
    parent: str
    child: str
    place: Pose = Pose()
    axis: Vector = (1.0, 0.0, 0.0)
    lower: float | None = None
    upper: float | None = None
    effort: float = 0.0
    velocity: float = 0.0
    damping: float = 0.0
    friction: float = 0.0
    rotor: float = 0.0
    stiffness: float = 0.0
    relaxed: float = 0.0
    mimic: Mimicked | None = None
    after: Vector = ORIGIN
    note: str = ""
    span: Span | None = None


@dataclass(frozen=True, slots=True)
class Link:
    """A link: a frame, with a body and pictures or without."""

    name: str
    body: Body | None = None
    pictures: tuple[Picture, ...] = ()
    span: Span | None = None


@dataclass(frozen=True, slots=True)
class Robot:
    """A tree: `links` from the root on, and for each but the root its joint in `joints`."""

    name: str
    file: str
    form: str
    links: dict[str, Link]
    joints: dict[str, Joint] = field(default_factory=dict)  # by the child's name
    gravity: Vector | None = None  # in the axes of the root, m/s^2; None for 9.81 along -z

    @property
    def root(self) -> str:
        """Name of the root link."""
        return next(iter(self.links))
