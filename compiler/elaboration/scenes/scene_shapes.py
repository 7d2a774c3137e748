"""Read the shapes of all parts, and make outputs of their poses where a scene records them.

A shape stands in the frame of its part: that of the part's incoming port, or its main one, whose
domain carries the position `r[3]` and the orientation `A[3, 3]`. A part without such a port has
the frame of the part around it; the scene's model has that of the world.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from bgc.algebra.evaluate import to_double
from bgc.diagnostics.catalogue import drawn, with_article
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.elaboration.bonds.bond_values import BondValues
from bgc.elaboration.bonds.wiring import Wiring
from bgc.elaboration.instances.checks import check_value
from bgc.elaboration.instances.components import component_names
from bgc.elaboration.instances.instance_notes import note
from bgc.elaboration.instances.scopes import ElementView, InstanceView, Names, PortView, path_of
from bgc.elaboration.instances.tree import Element, Environment, Instance, PortEntry
from bgc.elaboration.instances.world import World
from bgc.grammar import syntax
from bgc.ir.graph import Observation
from bgc.ir.shapes import ShapeUse, ShapeValue
from bgc.language.shape_table import COLOURS, MESH_FILES, SHAPES, Ends, ShapeArgument, Takes
from bgc.record_class import dataclass, field
from bgc.values.expressions import resolve_path
from bgc.values.units import DIMENSIONLESS, Dimension
from bgc.values.value import Value, describe_shape

_METRE: Dimension = (0, 1, 0, 0, 0, 0, 0)
_COLOUR = re.compile(r"#[0-9a-fA-F]{6}")
_ROUNDING = 2e-6  # of the axes of a shape, as of `is_rotation`


@dataclass(frozen=True, slots=True)
class Frame:
    """A position in the world and axes, as values; None where nothing writes them."""

    r: Value | None
    A: Value | None


@dataclass(slots=True)
class Shapes:
    """The shapes of a model, and the outputs that record their poses."""

    uses: list[ShapeUse] = field(default_factory=list)
    observations: list[Observation] = field(default_factory=list)


def read_shapes(world: World, bonds: BondValues, wiring: Wiring, record: bool) -> Shapes:
    """Check the shapes of all parts; where they are recorded, add an output for each pose.

    The nodes of a check are discarded, so that shapes change nothing in a model that does not
    record them.
    """
    found = Shapes()
    statements = [(i, *item) for i in wiring.instances for item in i.written(syntax.Shape)]
    if not statements:
        return found
    graph = world.dag
    world.dag = graph if record else graph.copy()
    counts: dict[str, int] = {}
    try:
        for instance, statement, env in statements:
            name = instance.within(statement.kind)
            counts[name] = counts.get(name, 0) + 1
            name = name if counts[name] == 1 else f"{name}[{counts[name]}]"
            with world.report.collecting(note(env)):
                _Reader(world, bonds, instance, env, statement, name, record, found).read()
    finally:
        world.dag = graph
    return found


@dataclass(slots=True)
class _Reader:
    """The reading of one shape."""

    world: World
    bonds: BondValues
    instance: Instance
    env: Environment
    item: syntax.Shape
    name: str
    record: bool
    found: Shapes
    values: list[ShapeValue] = field(default_factory=list)

    @property
    def what(self) -> str:
        """The shape and its ends, for messages."""
        ends = "" if self.item.ends is None else " between two frames"
        return with_article(self.item.kind) + ends

    def read(self) -> None:
        """Check the shape, and add it to those found."""
        item = self.item
        kind = SHAPES.get(item.kind)
        if kind is None:
            raise BgError([drawn.unknown_shape(item.kind_span, item.kind, SHAPES)])
        colour = self._colour()
        if item.ends is None and kind.ends is Ends.MUST:
            what = f"{self.what} has two ends"
            help = f"write `shape {item.kind} from a to b`"
            raise BgError([drawn.shape_place(item.kind_span, what, help)])
        if item.ends is not None and kind.ends is Ends.NEVER:
            span = item.ends[0].span.to(item.ends[1].span)
            what = f"{self.what} stands at one frame"
            raise BgError([drawn.shape_place(span, what, "write `at` and a frame or an offset")])
        if item.ends is not None and item.at is not None:
            what = f"this {item.kind} stands between two frames"
            raise BgError([drawn.shape_place(item.at.span, what, "omit `at`")])
        between = item.ends is not None
        file = self._arguments(kind.arguments_of(between), kind.form(item.kind, between))
        if not self._place():
            if self.record:
                self.world.report.add(drawn.shape_without_pose(item.span, self.name))
            return
        values = tuple(self.values) if self.record else ()
        use = ShapeUse(self.name, self.instance.path, item.kind, colour, file, values)
        self.found.uses.append(use)

    # --- arguments ------------------------------------------------------------------

    def _colour(self) -> str:
        text = self.item.colour
        if text is None:
            return ""
        if text in COLOURS:
            return COLOURS[text]
        if _COLOUR.fullmatch(text):
            return text.lower()
        raise BgError([drawn.unknown_colour(self.item.colour_span, text, list(COLOURS))])

    def _arguments(self, known: Sequence[ShapeArgument], form: str) -> str:
        """Read the arguments by name or position; return the file of a mesh."""
        item = self.item
        given: dict[str, syntax.Expr] = {}
        names = [argument.name for argument in known]
        for place, argument in enumerate(item.arguments):
            if argument.name is None and place >= len(names):
                most = f"at most {len(names)}" if names else "no"
                what = f"{self.what} takes {most} argument{'s' * (len(names) != 1)}"
                raise BgError([drawn.shape_arguments(argument.span, what, form)])
            name = names[place] if argument.name is None else argument.name
            if name not in names:
                what = f"{self.what} has no argument `{name}`"
                raise BgError([drawn.shape_arguments(argument.span, what, form)])
            if name in given:
                what = f"`{name}` is given twice"
                raise BgError([drawn.shape_arguments(argument.span, what, form)])
            given[name] = argument.value
        file = ""
        for argument_kind in known:
            value = given.get(argument_kind.name)
            if value is not None and argument_kind.takes is Takes.FILE:
                file = self._file(value)
            elif value is not None:
                self._argument(argument_kind, value)
            elif argument_kind.default is not None:
                default = ShapeValue(argument_kind.name, (), (argument_kind.default,))
                self.values.append(default)
            elif not argument_kind.optional:
                what = f"{self.what} needs its {argument_kind.name}"
                raise BgError([drawn.shape_arguments(item.kind_span, what, form)])
        return file

    def _argument(self, argument: ShapeArgument, expr: syntax.Expr) -> None:
        value = self.world.evaluate(expr, self.env)
        what = f"the {argument.name} of {with_article(self.item.kind)}"
        match argument.takes:
            case Takes.LENGTH:
                check_value(value, (), _METRE, expr.span, what)
                exact = self.world.dag.value(value.node)
                if exact is not None and exact <= 0:
                    raise BgError([drawn.size_of_shape(expr.span, what, to_double(exact))])
            case Takes.NUMBER:
                check_value(value, (), None, expr.span, what)
            case Takes.POINT:
                check_value(value, (3,), _METRE, expr.span, what)
            case Takes.VECTOR:
                check_value(value, (3,), None, expr.span, what)
            case Takes.WAVES if len(value.shape) != 2 or value.shape[1] != 4:
                message = (
                    f"{what} must be {argument.takes.value}, not {describe_shape(value.shape)}"
                )
                raise BgError([drawn.shape_arguments(expr.span, message, "sea(waves)")])
            case _:
                pass
        self._keep(argument.name, value)

    def _file(self, expr: syntax.Expr) -> str:
        """The path of a mesh as written, checked from the folder of its own file."""
        if not isinstance(expr, syntax.Text):
            what = "the file of a mesh is a text"
            raise BgError([drawn.shape_arguments(expr.span, what, 'mesh("hull.glb")')])
        text = expr.value
        if Path(text).suffix.lower() not in MESH_FILES:
            raise BgError([drawn.mesh_file(expr.span, text, "is of an unknown kind")])
        if not (Path(expr.span.source.name).parent / text).is_file():
            raise BgError([drawn.mesh_file(expr.span, text, "does not exist")])
        return text

    # --- places ---------------------------------------------------------------------

    def _place(self) -> bool:
        """Read the pose or the two ends; False where a frame has no known position."""
        item = self.item
        if item.ends is not None:
            ends = [self._frame_at(end).r for end in item.ends]
            for name, r in zip(("from", "to"), ends, strict=True):
                if r is None:
                    return False
                self._keep(name, r)
            return True
        if item.kind == "sea":
            if item.at is not None:
                what = "the sea is that of the world"
                raise BgError([drawn.shape_place(item.at.span, what, "omit `at`")])
            return True
        if item.kind == "handle" and item.at is None:
            return True  # it stands beside the scene
        frame = self._standing()
        if frame.r is None or frame.A is None:
            return False
        self._keep("r", frame.r)
        self._keep("A", frame.A)
        return True

    def _standing(self) -> Frame:
        """The pose of the shape: a frame, or an offset from that of its part, and its axes."""
        at = self.item.at
        if at is None:
            frame = self._own_frame(self.instance)
        elif self._names_a_frame(at):
            frame = self._frame_at(at)
        else:
            frame = self._moved(self._own_frame(self.instance), at)
        return frame if self.item.axes is None else self._turned(frame, self.item.axes)

    def _moved(self, frame: Frame, offset: syntax.Expr) -> Frame:
        d = self.world.evaluate(offset, self.env)
        check_value(d, (3,), _METRE, offset.span, "the offset of a shape")
        if frame.r is None or frame.A is None:
            return frame
        dag = self.world.dag
        nodes = tuple(
            dag.add(origin, dag.sum(dag.mul(a, x) for a, x in zip(row, d.nodes, strict=True)))
            for origin, row in zip(frame.r.nodes, frame.A.rows, strict=True)
        )
        return Frame(Value.vector(nodes, _METRE), frame.A)

    def _turned(self, frame: Frame, axes: syntax.Expr) -> Frame:
        dag = self.world.dag
        turn = self.world.evaluate(axes, self.env)
        check_value(turn, (3, 3), DIMENSIONLESS, axes.span, "the axes of a shape")
        exact = [dag.value(node) for node in turn.nodes]
        numbers = [to_double(x) for x in exact if x is not None]
        if len(numbers) == len(turn.nodes) and not _is_rotation(numbers):
            raise BgError([drawn.axes_turn(axes.span)])
        if frame.A is None:
            return frame
        rows = turn.rows
        nodes = [
            dag.sum(dag.mul(row[k], rows[k][column]) for k in range(3))
            for row in frame.A.rows
            for column in range(3)
        ]
        return Frame(frame.r, Value.uniform((3, 3), nodes, DIMENSIONLESS))

    # --- frames ---------------------------------------------------------------------

    def _names_a_frame(self, expr: syntax.Expr) -> bool:
        """Return whether an expression is a path to a part, a port, or the position `r` of one."""
        if not isinstance(expr, syntax.Name | syntax.Member | syntax.Index):
            return False
        if not isinstance(self._resolved(expr), Value):
            return True
        return (
            isinstance(expr, syntax.Member)
            and expr.name == "r"
            and isinstance(self._resolved(expr.base), PortView | ElementView)
        )

    def _resolved(self, expr: syntax.Expr) -> object:
        return resolve_path(expr, Names(self.world, self.env, {}, False), self.world.dag)

    def _frame_at(self, expr: syntax.Expr) -> Frame:
        """The frame at a path; of a position, `tip.r`, the axes are those of the world."""
        path, found = path_of(expr), self._resolved(expr)
        if isinstance(found, Value):
            check_value(found, (3,), _METRE, expr.span, f"the position `{path}`")
            return Frame(found, self._world().A)
        match found:
            case PortView(port=place) | ElementView(element=place) if self.bonds.has_pose(place):
                return self._pose_of(place, expr.span)
            case InstanceView(instance=instance) if _frame_port(self.bonds, instance) is not None:
                return self._own_frame(instance)
            case _:
                what = f"`{path}` is not a frame"
                help = "name a port, 1-junction or part whose domain carries `r[3]` and `A[3, 3]`"
                raise BgError([drawn.shape_place(expr.span, what, help)])

    def _own_frame(self, instance: Instance | None) -> Frame:
        """The frame of a part, or of the next part around it that has one."""
        while instance is not None:
            port = _frame_port(self.bonds, instance)
            if port is not None:
                return self._pose_of(port, self.item.span)
            instance = instance.parent
        return self._world()

    def _world(self) -> Frame:
        dag = self.world.dag
        axes = [dag.one if k % 4 == 0 else dag.zero for k in range(9)]
        return Frame(
            Value.vector([dag.zero] * 3, _METRE), Value.uniform((3, 3), axes, DIMENSIONLESS)
        )

    def _pose_of(self, place: PortEntry | Element, span: Span) -> Frame:
        """Position and axes of a port or 1-junction; None for those that nothing writes."""
        return Frame(*(self._signal(place, name, span) for name in ("r", "A")))

    def _signal(self, place: PortEntry | Element, name: str, span: Span) -> Value | None:
        read = self.bonds.of_port if isinstance(place, PortEntry) else self.bonds.of_element
        try:
            value = read(place, name, span)  # type: ignore[arg-type]
        except BgError as err:
            if [d.code for d in err.diagnostics] == ["BG420"]:
                return None
            raise
        assert isinstance(value, Value)
        return value

    # --- values ---------------------------------------------------------------------

    def _keep(self, name: str, value: Value) -> None:
        """Keep a quantity: as numbers if it is constant, otherwise as outputs."""
        if not self.record:
            return
        exact = [self.world.dag.value(node) for node in value.nodes]
        numbers = tuple(to_double(x) for x in exact if x is not None)
        if len(numbers) == len(value.nodes):
            self.values.append(ShapeValue(name, value.shape, numbers))
            return
        # A blank keeps these names distinct from all names of the language.
        columns = tuple(component_names(f"shape {self.name} {name}", value.shape))
        for column, node in zip(columns, value.nodes, strict=True):
            self.found.observations.append(Observation(column, "", node, self.item.span))
        self.values.append(ShapeValue(name, value.shape, None, columns))


def _frame_port(bonds: BondValues, instance: Instance) -> PortEntry | None:
    """The port whose frame is that of a part: the one that comes in, else the main one."""
    ports = [m for m in instance.members.values() if isinstance(m, PortEntry) and bonds.has_pose(m)]
    coming = [p for p in ports if p.declaration.direction is syntax.Direction.IN]
    for chosen in (coming, [p for p in coming if p.declaration.main], ports):
        if len(chosen) == 1:
            return chosen[0]
    main = (p for p in ports if p.declaration.main)
    return next(main, ports[0] if ports else None)


def _is_rotation(m: Sequence[float]) -> bool:
    """Return whether nine numbers, by rows, are a right-handed rotation to six digits."""
    rows = [m[0:3], m[3:6], m[6:9]]
    products = [sum(x * y for x, y in zip(a, b, strict=True)) for a in rows for b in rows]
    square = all(abs(p - (k % 4 == 0)) < _ROUNDING for k, p in enumerate(products))
    (a, b, c), (d, e, f), (g, h, i) = rows
    return square and a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) > 0
