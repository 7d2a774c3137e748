"""Infer the width of an element from its arguments and law, before all widths are known."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.elaboration.instances.faces import Face
from bgc.elaboration.instances.tree import Element
from bgc.elaboration.instances.world import World
from bgc.grammar import syntax
from bgc.record_class import dataclass, field
from bgc.values.value import Shape

LAW_VARIABLES = {"e", "f", "p", "q", "e1", "f1", "e2", "f2"}


class WidthUnknown(Exception):
    """A value depends on a width that is not known yet."""


@dataclass(slots=True)
class Probe:
    """Inferred widths by side (`all`, `in`, `out`); `same` if both sides have equal widths."""

    span: Span
    sizes: dict[str, int] = field(default_factory=dict)
    same: bool = False


def probe(world: World, element: Element) -> Probe:
    """Infer the widths that the arguments and the law of an element imply.

    Scalars imply no width. Raises WidthUnknown if a value depends on a width not known yet.
    """
    found = Probe(element.use.span)
    two_port = "in" in element.faces
    for argument in element.use.arguments:
        if isinstance(argument.value, syntax.Text | syntax.TypeUse):
            continue
        shape = world.evaluate(argument.value, element.env).shape
        if two_port and len(shape) == 2:
            found.sizes["out"], found.sizes["in"] = shape
        elif not two_port and shape:
            found.sizes["all"] = shape[0]
    if element.law:
        _LawProbe(world, element, found).run()
    if two_port and not found.sizes and len(element.dims) != 2:
        found.same = True
    return found


class _LawProbe:
    """Infers shapes within a law, in which the element's own variables may have unknown width."""

    def __init__(self, world: World, element: Element, found: Probe) -> None:
        self.world, self.element, self.found = world, element, found

    def run(self) -> None:
        assert self.element.law is not None
        for equation in self.element.law:
            right = self.shape(equation.right)
            match equation.left:
                case syntax.Name(name=name) if right and name in LAW_VARIABLES:
                    self.note(name, right[0])
                case syntax.Index(base=syntax.Name(name=name), indices=(index,)) if not isinstance(
                    index, syntax.Range
                ):
                    at = self.world.whole(index, self.element.env, "an index", 1, 10_000)
                    side = self.side(name)
                    self.found.sizes[side] = max(at, self.found.sizes.get(side, 1))
                case _:
                    pass

    def side(self, variable: str) -> str:
        if "all" in self.element.faces or len(variable) == 1:
            return "all" if "all" in self.element.faces else "in"
        return "in" if variable.endswith("1") else "out"

    def note(self, variable: str, size: int) -> None:
        self.found.sizes.setdefault(self.side(variable), size)

    def known(self, variable: str) -> Shape | None:
        side = self.side(variable)
        if side in self.found.sizes:
            return (self.found.sizes[side],)
        width = self.element.faces[side].net.root().width
        return (width.size,) if width is not None and width.size > 1 else None

    def shape(self, expr: syntax.Expr) -> Shape | None:
        """The shape of an expression, None if it cannot be inferred.

        A matrix times a variable of unknown width gives this variable its width.
        """
        if not _holds_law_variables(expr):
            return self.shape_of_value(expr)
        match expr:
            case syntax.Name(name=name):
                return self.known(name)
            case syntax.Binary():
                return self.shape_of_chain(expr.links())
            case syntax.Unary():
                return self.shape(expr.operand)
            case syntax.Conditional():
                yes, no = self.shape(expr.yes), self.shape(expr.no)
                return yes if yes is not None else no
            case syntax.Call():
                for argument in expr.arguments:
                    self.shape(argument)
                return None
            case syntax.Vector():
                return (len(expr.elements),)
            case _:
                return None

    def shape_of_value(self, expr: syntax.Expr) -> Shape | None:
        try:
            return self.world.evaluate(expr, self.element.env).shape
        except BgError:
            return None  # reported when the law is read

    def shape_of_chain(self, links: Sequence[syntax.Binary]) -> Shape | None:
        """The shape of the last link; the links before the first law variable are a value."""
        begin = links[0].left
        count = 0
        if not _holds_law_variables(begin):
            while not _holds_law_variables(links[count].right):
                begin = links[count]
                count += 1
        shape = self.shape(begin)
        for link in links[count:]:
            shape = self.shape_of_operation(link, shape, self.shape(link.right))
        return shape

    def shape_of_operation(
        self, link: syntax.Binary, left: Shape | None, right: Shape | None
    ) -> Shape | None:
        match link.operator:
            case "*":
                if left is not None and len(left) == 2:
                    if right is None and isinstance(link.right, syntax.Name):
                        self.note(link.right.name, left[1])
                    return (left[0],) if right is None or len(right) < 2 else (left[0], right[1])
                return right if left == () else left if right == () else None
            case "+" | "-":
                return left if left is not None else right
            case _:
                return None


def _holds_law_variables(expr: syntax.Expr) -> bool:
    return any(name in LAW_VARIABLES for name in names_in(expr))


def names_in(expr: syntax.Expr) -> Iterator[str]:
    """All plain names in an expression, including the first names of paths."""
    match expr:
        case syntax.Name():
            yield expr.name
        case syntax.Member():
            yield from names_in(expr.base)
        case syntax.Index():
            yield from names_in(expr.base)
            for index in expr.indices:
                for part in (
                    (index.first, index.last) if isinstance(index, syntax.Range) else (index,)
                ):
                    yield from names_in(part)
        case syntax.Call():
            for argument in expr.arguments:
                yield from names_in(argument)
        case syntax.Unary():
            yield from names_in(expr.operand)
        case syntax.Binary():
            for part in expr.operands():
                yield from names_in(part)
        case syntax.Conditional():
            for part in (expr.condition, expr.yes, expr.no):
                yield from names_in(part)
        case syntax.Vector():
            for part in expr.elements:
                yield from names_in(part)
        case _:
            pass


def width_of(face: Face) -> int:
    """The width of a face; WidthUnknown if it is not known yet."""
    width = face.net.root().width
    if width is None:
        raise WidthUnknown
    return width.size


def shape_of(face: Face) -> Shape:
    """The shape of a face's variables: a vector if it is wide or has brackets, else a scalar."""
    width = face.net.root().width
    if width is None:
        raise WidthUnknown
    return (width.size,) if width.size > 1 or width.explicit else ()
