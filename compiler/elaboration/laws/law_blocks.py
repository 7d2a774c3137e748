"""Read arguments and law blocks of elements: names, shapes, units and permitted variables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from bgc.algebra.dag import Kind
from bgc.algebra.linear import linear_coefficients
from bgc.diagnostics.catalogue import laws as law_messages
from bgc.diagnostics.catalogue import names, with_article
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Span
from bgc.elaboration.bonds.bond_values import BondValues
from bgc.elaboration.bonds.scalarise import Scalars
from bgc.elaboration.bonds.shape_probe import names_in
from bgc.elaboration.instances.checks import check_units, check_value
from bgc.elaboration.instances.faces import Face
from bgc.elaboration.instances.scopes import find_member
from bgc.elaboration.instances.tree import Element, Quantity
from bgc.elaboration.instances.world import World
from bgc.grammar import syntax
from bgc.ir.graph import Matrix, Node, Port
from bgc.language.elements import Role
from bgc.record_class import dataclass, replace
from bgc.values.units import divide
from bgc.values.value import Value, describe_shape


@dataclass(frozen=True, slots=True)
class Laws:
    """Reads the values, matrices and equations of the laws of one graph."""

    world: World
    values: BondValues
    scalars: Scalars

    def ports(self, element: Element, side: str) -> tuple[Port, ...]:
        """The ports of one side of an element other than a junction, one per component."""
        return tuple(found[0] for found in self.scalars.ports(element.faces[side]))

    # --- shapes ---------------------------------------------------------------------

    def vector(
        self, value: Value, width: int, span: Span, what: str, *, spread: bool
    ) -> tuple[Node, ...]:
        """One node per component; a scalar is repeated if `spread`, the number zero always."""
        if len(value.nodes) == width and (len(value.shape) < 2 or value.shape[1] == 1):
            return value.nodes
        if value.is_scalar and (spread or value.nodes == (self.world.dag.zero,)):
            return value.nodes * width
        expected = f"a vector of {width}" if width > 1 else "a scalar"
        raise BgError(
            [law_messages.wrong_matrix(span, what, expected, describe_shape(value.shape))]
        )

    def matrix(self, value: Value, rows: int, columns: int, span: Span, what: str) -> Matrix:
        """A matrix of the given size; BgError for any other shape."""
        if value.shape != (rows, columns):
            expected, found = (
                with_article(f"{rows} x {columns} matrix"),
                describe_shape(value.shape),
            )
            raise BgError([law_messages.wrong_matrix(span, what, expected, found)])
        return value.rows

    def square(self, value: Value, width: int, span: Span, what: str) -> Matrix:
        """A square matrix; a scalar or vector is its diagonal."""
        if len(value.shape) == 2:
            return self.matrix(value, width, width, span, what)
        zero = self.world.dag.zero
        nodes = self.vector(value, width, span, what, spread=True)
        return tuple(
            tuple(nodes[i] if i == j else zero for j in range(width)) for i in range(width)
        )

    def check_entries(
        self, element: Element, value: Value, left: str, right: str, span: Span, what: str
    ) -> None:
        """Raise BgError if `left = value * right` contradicts the units of the two variables.

        A scalar or vector is a diagonal. This check is needed since the inference of units uses
        the diagonal only, and no values that depend on bonds.
        """
        rows, columns = self.variable(element, left).units, self.variable(element, right).units
        count = len(columns)
        for k, unit in enumerate(value.units):
            if len(value.shape) == 2:
                (i, j), label = divmod(k, count), f"entry [{k // count + 1}, {k % count + 1}] of "
            else:
                i, j, label = k, k, f"component [{k + 1}] of " if value.shape else ""
            effect, cause = rows[i], columns[j]
            if unit is not None and effect is not None and cause is not None:
                scalar = Value.scalar(value.nodes[k], unit)
                wanted = divide(effect, cause)
                check_units(scalar, wanted, span, f"{label}{what}")

    # --- law blocks -----------------------------------------------------------------

    def variable(self, element: Element, name: str) -> Value:
        """The variable of an element denoted by a name without a path in its law."""
        if name in {"q", "p"}:
            return self.values.storage(element, name)
        value = self.values.variable(face_of(element, name), name[0])
        # In the law of `MTF[1, 2]` a side of width 1 is a vector too, `f1[1]`.
        return replace(value, shape=(1,)) if len(element.dims) == 2 and value.is_scalar else value

    def linear_law(
        self,
        element: Element,
        law: Sequence[syntax.LawEquation],
        right: Mapping[str, str],
        have: Sequence[str],
    ) -> tuple[str, Matrix]:
        """The left side of equations that are linear in their right variable, and their matrix.

        That variable has symbols of its own here, since its node may also be that of a flow of the
        whole junction, which the coefficients may read.
        """
        dag, left = self.world.dag, left_name(law[0])
        own = self.variable(element, right[left]) if left in right else None
        symbols = [dag.symbol(Kind.OWN, k) for k, _ in enumerate(own.nodes if own else ())]
        apart = replace(own, nodes=tuple(symbols)) if own else None
        _, nodes = self.equations(element, law, right, have, apart)
        matrix = linear_coefficients(dag, nodes, symbols)
        if matrix is None:
            raise BgError([law_messages.law_not_linear(law[0].span, element.path, right[left])])
        return left, matrix

    def equations(
        self,
        element: Element,
        law: Sequence[syntax.LawEquation],
        right: Mapping[str, str],
        have: Sequence[str],
        apart: Value | None = None,
    ) -> tuple[str, tuple[Node, ...]]:
        """The common left side of these equations, and one node for each of its components.

        `right` maps each permitted left side to the variable of its right side, whose value is
        `apart` if that is given; `have` lists the permitted equations for messages.
        """
        left = left_name(law[0])
        for equation in law:
            name = left_name(equation)
            if name not in right:
                text = " ".join(equation.left.span.text.split())
                raise BgError(
                    [law_messages.law_not_of_this(equation.left.span, element.kind, text, have)]
                )
            if name != left:
                raise BgError([law_messages.law_too_many(equation.span, element.path, "keep one")])
        own = self.variable(element, left)
        width = len(own.nodes)
        found: dict[int, Node] = {}
        for equation in law:
            for at, component in self._components(
                element, equation, left, right[left], width, apart
            ):
                if at in found:
                    raise BgError(
                        [
                            law_messages.law_incomplete(
                                equation.span, element.path, left, width, at + 1, repeated=True
                            )
                        ]
                    )
                check_units(component, own.units[at], equation.right.span, f"`{left}`")
                found[at] = component.node
        for at in range(width):
            if at not in found:
                raise BgError(
                    [law_messages.law_incomplete(law[0].span, element.path, left, width, at + 1)]
                )
        return left, tuple(found[at] for at in range(width))

    def _components(
        self,
        element: Element,
        equation: syntax.LawEquation,
        left: str,
        right: str,
        width: int,
        apart: Value | None,
    ) -> list[tuple[int, Value]]:
        """The components (from 0) that one equation defines, with their values."""
        value = self.right_side(element, equation, left, (right,), apart)
        span = equation.right.span
        if isinstance(equation.left, syntax.Name):
            nodes = self.vector(value, width, span, f"`{left}`", spread=False)
            units = value.units if len(value.units) == width else value.units * width
            pairs = zip(nodes, units, strict=True)
            return list(enumerate(Value.scalar(node, unit) for node, unit in pairs))
        assert isinstance(equation.left, syntax.Index)
        (index, *more) = equation.left.indices
        if more or isinstance(index, syntax.Range):
            at, text = equation.left.span, equation.left.span.text
            raise BgError(
                [law_messages.law_not_of_this(at, element.kind, text, [f"{left}[1] = .."])]
            )
        place = self.world.whole(index, element.env, "an index", 1, width)
        check_value(value, (), None, span, f"`{left}`")
        return [(place - 1, value)]

    def right_side(
        self,
        element: Element,
        equation: syntax.LawEquation,
        left: str,
        allowed: Sequence[str],
        apart: Value | None = None,
    ) -> Value:
        """The value of a law's right side; BgError for a variable that is not `allowed`.

        `apart`, if given, is the value of the allowed variables.
        """
        two_port = len(allowed[0]) == 2
        own = ("e1", "f1", "e2", "f2") if two_port else ("e", "f", "p", "q")
        # Paths (`body.p`) are not checked here, although they may lead to the same bond.
        bare = set(names_in(equation.right))
        span = equation.right.span
        for name in own:
            if name not in bare:
                continue
            if isinstance(find_member(element.env, name), Quantity):
                raise BgError([law_messages.law_variable_is_a_name(span, name)])
            if name not in allowed:
                raise BgError(
                    [
                        law_messages.law_variable_misplaced(
                            span, with_article(element.kind), left, name, allowed[0]
                        )
                    ]
                )
        extra = {name: apart or self.variable(element, name) for name in allowed}
        return self.world.evaluate(equation.right, element.env, extra)


def face_of(element: Element, variable: str) -> Face:
    """The face of a variable in a law: the output side for `e2` and `f2`, where power leaves."""
    if len(variable) == 2:
        return element.faces["in" if variable[1] == "1" else "out"]
    return element.faces.get("all") or element.faces["in"]


def left_name(equation: syntax.LawEquation) -> str:
    """The variable on the left side, `e` for `e[1]`; empty for any other expression."""
    match equation.left:
        case syntax.Name(name=name) | syntax.Index(base=syntax.Name(name=name)):
            return name
        case _:
            return ""


def missing_law(element: Element) -> BgError:
    """The error for an element with neither argument nor law."""
    way = element.row.missing
    return BgError([law_messages.law_missing(element.span, element.path, element.kind, way)])


def arguments_of(element: Element, allowed: tuple[str, ...]) -> dict[str, syntax.Argument]:
    """The arguments by name; a positional first argument is that of the first allowed name."""
    found: dict[str, syntax.Argument] = {}
    problems = []
    what = with_article(element.kind)
    for k, argument in enumerate(element.use.arguments):
        name = argument.name
        if name is None and k == 0 and allowed:
            name = allowed[0]
        if name is None:
            problems.append(names.positional_argument(argument.span, what, allowed))
        elif name in {"q0", "p0", "e0", "f0"} and name not in allowed:
            have = element.row.initial_arguments
            problems.append(law_messages.initial_not_of_this(argument.span, name, what, have))
        elif name not in allowed:
            in_braces = f"a law stands in braces: `{element.kind} {{ {name} = ..; }}`"
            advice = in_braces if name in element.row.law_starts else ""
            problems.append(names.unknown_argument(argument.span, name, what, allowed, advice))
        elif name in found:
            problems.append(names.given_twice(argument.span, name, found[name].span))
        else:
            found[name] = argument
    if problems:
        raise BgError(problems)
    return found


def value_argument(element: Element) -> tuple[str, syntax.Argument] | None:
    """The argument that is an element's law or value, with its name; used to infer units."""
    known = [each.name for each in element.row.arguments if each.role is not Role.INITIAL]
    for k, argument in enumerate(element.use.arguments):
        name = argument.name or (known[0] if k == 0 and known else "")
        if name in known:
            return name, argument
    return None
