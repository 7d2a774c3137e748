"""From the arguments and law blocks of elements to the flat graph's elements with their laws."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from bgc.bond_values import BondValues
from bgc.dag import Kind, Level
from bgc.evaluate import evaluate_nodes
from bgc.faces import Face
from bgc.grammar import syntax
from bgc.grammar.catalogue import graph as messages
from bgc.grammar.catalogue import names
from bgc.grammar.diagnostics import BgError
from bgc.grammar.source import Span
from bgc.graph import (
    Element as GraphElement,
)
from bgc.graph import (
    EnergyLaw,
    ExplicitLaw,
    Form,
    Gyrator,
    Gyristor,
    Initial,
    Junction,
    Law,
    LinearLaw,
    Matrix,
    Port,
    Resistor,
    Source,
    Storage,
    Transformer,
)
from bgc.linear import linear_coefficients
from bgc.quantities import level_of
from bgc.scalarise import Scalars
from bgc.scopes import find_member
from bgc.shape_probe import names_in
from bgc.tree import Element, Quantity
from bgc.value import Value, describe_shape
from bgc.world import World

Node: TypeAlias = int

# The names an argument may have, the form it gives the law, for each kind of element.
_ARGUMENTS: dict[str, dict[str, Form]] = {
    "C": {"compliance": Form.DISPLACEMENT, "stiffness": Form.EFFORT},
    "I": {"inertia": Form.MOMENTUM},
    "R": {"resistance": Form.EFFORT, "conductance": Form.FLOW},
}
_INITIAL = {"C": ("q0", "e0"), "I": ("p0", "f0"), "IC": ("q0", "p0", "e0", "f0")}
_VALUE = {"Se": "e", "Sf": "f", "TF": "ratio", "GY": "ratio"}
_WAYS = {
    "Se": "give its effort: `Se(e = 5)`",
    "Sf": "give its flow: `Sf(f = 1)`",
    "C": "give its compliance, `C(c)` or `C(stiffness = k)`, or a law: `C { e = k*q; }`",
    "I": "give its inertia, `I(m)`, or a law: `I { f = p/m; }`",
    "R": "give its resistance, `R(r)` or `R(conductance = g)`, or a law: `R { e = r*f; }`",
    "IC": "give its energy: `IC { H = p^2/(2*m) + k*q^2/2; }`",
    "TF": "give its ratio, `TF(m)`, or a law: `TF { f2 = m*f1; }`",
    "GY": "give its ratio, `GY(r)`, or a law: `GY { e2 = r*f1; }`",
}
# Of each left side: the variable the right side holds, and the form.
_ONE_PORT_LAWS: dict[str, dict[str, tuple[str, Form]]] = {
    "C": {"e": ("q", Form.EFFORT), "q": ("e", Form.DISPLACEMENT)},
    "I": {"f": ("p", Form.FLOW), "p": ("f", Form.MOMENTUM)},
    "R": {"e": ("f", Form.EFFORT), "f": ("e", Form.FLOW)},
}
_TWO_PORT_LAWS = {
    "TF": {"f2": "f1", "e1": "e2", "f1": "f2", "e2": "e1"},
    "GY": {"e2": "f1", "e1": "f2"},
}


@dataclass(frozen=True, slots=True)
class LawReader:
    """Reads the laws of all elements of one graph."""

    world: World
    values: BondValues
    scalars: Scalars

    def read(self, element: Element) -> list[GraphElement]:
        """The flat graph's elements that an element stands for; BgError when it has no law."""
        match element.basic:
            case "J0" | "J1":
                return self._junctions(element)
            case "Se" | "Sf":
                return self._sources(element)
            case "C" | "I" | "IC":
                return [self._storage(element)]
            case "R":
                return [self._resistor(element)]
            case "TF":
                return self._transformers(element)
            case "GY" if element.faces["out"].joints:
                return self._gyrators(element)
            case "GY":
                return [self._gyristor(element)]
            case _:
                return []  # a Mux has dissolved

    # --- junctions and sources ------------------------------------------------------

    def _junctions(self, element: Element) -> list[GraphElement]:
        _refuse_arguments(element, ())
        if element.law is not None:
            raise BgError([messages.law_not_of_this(element.span, element.kind, "{ }", ())])
        return [
            Junction(name, element.basic, tuple(ports), element.span)
            for name, ports in self._components(element, element.faces["all"])
        ]

    def _sources(self, element: Element) -> list[GraphElement]:
        argument = _VALUE[element.basic]
        given = _arguments(element, (argument,))
        if element.law is not None:
            value = self._source_law(element, argument)
        elif argument in given:
            value = self._evaluate(element, given[argument])
        else:
            raise self._missing(element)
        face = element.faces["all"]
        nodes = self._spread(element, value, face)
        return [
            Source(name, element.basic, ports[0], node, element.span)
            for (name, ports), node in zip(self._components(element, face), nodes, strict=True)
        ]

    def _source_law(self, element: Element, variable: str) -> Value:
        """`Se { e = 5*sin(time); }` is the same as an argument."""
        assert element.law is not None
        (first, *rest) = element.law or (None,)
        if first is None:
            raise self._missing(element)
        left = first.left
        if not isinstance(left, syntax.Name) or left.name != variable:
            text = " ".join(left.span.text.split())
            raise BgError(
                [messages.law_not_of_this(left.span, element.kind, text, [f"{variable} = .."])]
            )
        if rest:
            raise BgError([messages.law_too_many(rest[0].span, element.path, "keep one")])
        return self.world.evaluate(first.right, element.env)

    # --- storage and resistors ------------------------------------------------------

    def _storage(self, element: Element) -> Storage:
        kind = element.basic
        face = element.faces["all"]
        given = _arguments(element, (*_ARGUMENTS.get(kind, {}), *_INITIAL[kind]))
        law = self._one_port_law(element, given)
        own = {Kind.DISPLACEMENT, Kind.MOMENTUM} if kind == "IC" else set()
        own |= {Kind.DISPLACEMENT} if kind == "C" else {Kind.MOMENTUM} if kind == "I" else set()
        if self._depends(law, element, own):
            raise BgError([messages.storage_varies(element.use.span, element.path, kind)])
        ports = tuple(found[0] for found in self.scalars.ports(face))
        initial = []
        for name in _INITIAL[kind]:
            if name not in given:
                continue
            value = self._evaluate(element, given[name])
            self.world.quantities.require_level(
                value, Level.TIME, given[name].span, f"`{name}` of `{element.path}`"
            )
            self._check_unit(element, name, value, given[name])
            for k, node in enumerate(self._spread(element, value, face, given[name].span)):
                initial.append(Initial(k, name[0], node, given[name].span))
        return Storage(
            element.path, kind, ports, law, element.first_state, tuple(initial), element.span
        )

    def _resistor(self, element: Element) -> Resistor:
        given = _arguments(element, tuple(_ARGUMENTS["R"]))
        law = self._one_port_law(element, given)
        assert not isinstance(law, EnergyLaw)
        if element.kind == "R" and self._depends(law, element, {Kind.EFFORT, Kind.FLOW}):
            raise BgError([messages.modulated(element.use.span, element.path, "R")])
        ports = tuple(found[0] for found in self.scalars.ports(element.faces["all"]))
        return Resistor(element.path, ports, law, element.span)

    def _one_port_law(self, element: Element, given: dict[str, syntax.Argument]) -> Law:
        forms = _ARGUMENTS.get(element.basic, {})
        named = [name for name in forms if name in given]
        if element.law is not None and named:
            raise BgError([messages.law_and_argument(given[named[0]].span, element.path, named[0])])
        if len(named) > 1:
            raise BgError(
                [names.given_twice(given[named[1]].span, element.path, given[named[0]].span)]
            )
        if named:
            value = self._evaluate(element, given[named[0]])
            span = given[named[0]].span
            return LinearLaw(forms[named[0]], self._square(element, value, span))
        if not element.law:
            raise self._missing(element)
        return self._one_port_equation(element, element.law)

    def _one_port_equation(self, element: Element, law: Sequence[syntax.LawEquation]) -> Law:
        face = element.faces["all"]
        kind = element.basic
        first = law[0].left
        if isinstance(first, syntax.Name) and first.name == "H" and kind in {"C", "I", "IC"}:
            if len(law) > 1:
                raise BgError([messages.law_too_many(law[1].span, element.path, "keep one")])
            variables = {"C": ("q",), "I": ("p",), "IC": ("q", "p")}[kind]
            value = self._law_value(element, law[0], "H", variables)
            if not value.is_scalar:
                raise BgError(
                    [
                        messages.wrong_matrix(
                            law[0].right.span, "`H`", "a scalar", describe_shape(value.shape)
                        )
                    ]
                )
            return EnergyLaw(value.node)
        table = _ONE_PORT_LAWS.get(kind, {})
        have = [f"{left} = .." for left in table]
        have += ["H = .."] if kind in {"C", "I", "IC"} else []
        left, nodes = self._equations(element, law, face, {k: v[0] for k, v in table.items()}, have)
        variable, form = table[left]
        symbols = self._law_variable(element, variable).nodes
        matrix = linear_coefficients(self.world.dag, nodes, symbols)
        if matrix is not None:
            return LinearLaw(form, matrix)
        if form in {Form.DISPLACEMENT, Form.MOMENTUM}:
            raise BgError([messages.law_not_linear(law[0].span, element.path, variable)])
        return ExplicitLaw(form, nodes)

    # --- two-ports ------------------------------------------------------------------

    def _transformers(self, element: Element) -> list[GraphElement]:
        into, out = element.faces["in"], element.faces["out"]
        given = _arguments(element, ("ratio",))
        self._one_way(element, given)
        if "ratio" in given:
            value = self._evaluate(element, given["ratio"])
            self._check_modulated(element, [value])
            if len(value.shape) < 2:
                return self._scalar_transformers(element, value, given["ratio"].span)
            matrix = self._matrix(element, value, _width(out), _width(into), given["ratio"].span)
            return [self._transformer(element, "f2", matrix, None)]
        if not element.law:
            raise self._missing(element)
        laws = self._two_port_equations(element, element.law)
        first, second = laws[0], laws[1] if len(laws) > 1 else None
        self._check_modulated_nodes(element, [n for _, m in laws for row in m for n in row])
        inverse = None
        if second is not None:
            backwards = {"f2": "f1", "f1": "f2", "e1": "e2", "e2": "e1"}
            if backwards[first[0]] != second[0]:
                raise BgError(
                    [messages.law_too_many(element.law[1].span, element.path, "keep one")]
                )
            inverse = second[1]
            self._check_inverse(element, first[1], inverse)
        left, matrix = first
        if left in {"e1", "e2"}:  # e1 = m' e2, e2 = w' e1
            matrix = _transposed(matrix)
            inverse = _transposed(inverse) if inverse is not None else None
        return [self._transformer(element, left, matrix, inverse)]

    def _transformer(
        self, element: Element, given: str, matrix: Matrix, inverse: Matrix | None
    ) -> Transformer:
        ports1, ports2 = self._two_sides(element)
        return Transformer(element.path, given, ports1, ports2, matrix, inverse, element.span)

    def _scalar_transformers(
        self, element: Element, value: Value, span: Span
    ) -> list[GraphElement]:
        nodes = self._spread(element, value, element.faces["in"], span)
        return [
            Transformer(name, "f2", (one,), (two,), ((node,),), None, element.span)
            for name, one, two, node in self._pairs(element, nodes)
        ]

    def _gyrators(self, element: Element) -> list[GraphElement]:
        into, out = element.faces["in"], element.faces["out"]
        given = _arguments(element, ("ratio",))
        self._one_way(element, given)
        ports1, ports2 = self._two_sides(element)
        if "ratio" in given:
            value = self._evaluate(element, given["ratio"])
            self._check_modulated(element, [value])
            span = given["ratio"].span
            if len(value.shape) < 2:
                nodes = self._spread(element, value, into, span)
                return [
                    Gyrator(name, (one,), (two,), ((node,),), element.span)
                    for name, one, two, node in self._pairs(element, nodes)
                ]
            matrix = self._matrix(element, value, _width(out), _width(into), span)
            return [Gyrator(element.path, ports1, ports2, matrix, element.span)]
        if not element.law:
            raise self._missing(element)
        laws = self._two_port_equations(element, element.law)
        if len(laws) > 1:
            raise BgError([messages.law_too_many(element.law[1].span, element.path, "keep one")])
        left, matrix = laws[0]
        self._check_modulated_nodes(element, [n for row in matrix for n in row])
        matrix = matrix if left == "e2" else _transposed(matrix)
        return [Gyrator(element.path, ports1, ports2, matrix, element.span)]

    def _two_port_equations(
        self, element: Element, law: Sequence[syntax.LawEquation]
    ) -> list[tuple[str, Matrix]]:
        """Each left side with its matrix, in the order written."""
        table = _TWO_PORT_LAWS[element.basic]
        groups: dict[str, list[syntax.LawEquation]] = {}
        for equation in law:
            groups.setdefault(_left_name(equation), []).append(equation)
        found = []
        for left, equations in groups.items():
            face = element.faces["in" if left.endswith("1") else "out"]
            have = [f"{name} = .." for name in table]
            _, nodes = self._equations(element, equations, face, table, have)
            symbols = self._law_variable(element, table[left]).nodes
            matrix = linear_coefficients(self.world.dag, nodes, symbols)
            if matrix is None:
                raise BgError(
                    [messages.law_not_linear(equations[0].span, element.path, table[left])]
                )
            found.append((left, matrix))
        if len(found) > 2:
            raise BgError([messages.law_too_many(law[2].span, element.path, "keep one")])
        return found

    def _gyristor(self, element: Element) -> Gyristor:
        """An MGY with bonds on one side: `e = S f` with a skew S (eq. 13)."""
        _arguments(element, ())
        face = element.faces["in"]
        if not element.law:
            side = messages.one_sided(element.span, element.path, element.kind, "out of")
            raise BgError([side])
        _, nodes = self._equations(element, element.law, face, {"e": "f"}, ["e = .."])
        symbols = self._law_variable(element, "f").nodes
        matrix = linear_coefficients(self.world.dag, nodes, symbols)
        if matrix is None:
            raise BgError([messages.law_not_linear(element.law[0].span, element.path, "f")])
        self._check_modulated_nodes(element, [n for row in matrix for n in row])
        dag = self.world.dag
        size = len(matrix)
        places = [(i, j) for i in range(size) for j in range(i, size)]
        sums = [dag.add(matrix[i][j], matrix[j][i]) for i, j in places]
        for (i, j), number, scale in zip(
            places,
            self._numbers(sums),
            self._numbers([matrix[i][j] for i, j in places]),
            strict=True,
        ):
            if abs(number) > 1e-9 * max(abs(scale), 1e-300):
                raise BgError([messages.not_skew(element.law[0].span, element.path, i + 1, j + 1)])
        ports = tuple(found[0] for found in self.scalars.ports(face))
        return Gyristor(element.path, ports, matrix, element.span)

    def _check_inverse(self, element: Element, matrix: Matrix, inverse: Matrix) -> None:
        """BgError unless the product of the two is the identity at random values."""
        dag = self.world.dag
        assert element.law is not None
        columns = list(zip(*matrix, strict=True))
        products = [dag.dot(row, column) for row in inverse for column in columns]
        size = len(columns)
        fits = len(inverse) == size and len(matrix) == len(inverse[0])
        for k, number in enumerate(self._numbers(products) if fits else []):
            if abs(number - (k // size == k % size)) > 1e-6:
                fits = False
        if not fits:
            raise BgError([messages.inverse_differs(element.law[1].span, element.path)])

    # --- law blocks -----------------------------------------------------------------

    def _equations(
        self,
        element: Element,
        law: Sequence[syntax.LawEquation],
        face: Face,
        table: dict[str, str],
        have: Sequence[str],
    ) -> tuple[str, tuple[Node, ...]]:
        """The left side's name, and one node for each component of it."""
        left = _left_name(law[0])
        for equation in law:
            name = _left_name(equation)
            if name not in table:
                text = " ".join(equation.left.span.text.split())
                raise BgError(
                    [messages.law_not_of_this(equation.left.span, element.kind, text, have)]
                )
            if name != left:
                raise BgError([messages.law_too_many(equation.span, element.path, "keep one")])
        width = _width(face)
        found: dict[int, Node] = {}
        for equation in law:
            value = self._law_value(element, equation, left, (table[left],))
            if isinstance(equation.left, syntax.Name):
                nodes = self._vector(element, left, value, width, equation.right.span)
                pairs = list(enumerate(nodes))
            else:
                (at,) = self._component(element, equation.left, width)
                self.world.quantities.check(value, (), None, equation.right.span, f"`{left}`")
                pairs = [(at - 1, value.nodes[0])]
            for at, node in pairs:
                if at in found:
                    raise BgError(
                        [messages.law_incomplete(equation.span, element.path, left, width, at + 1)]
                    )
                found[at] = node
        for at in range(width):
            if at not in found:
                raise BgError(
                    [messages.law_incomplete(law[0].span, element.path, left, width, at + 1)]
                )
        return left, tuple(found[at] for at in range(width))

    def _component(self, element: Element, left: syntax.Expr, width: int) -> tuple[int]:
        assert isinstance(left, syntax.Index)
        (index, *more) = left.indices
        if more or isinstance(index, syntax.Range):
            raise BgError(
                [messages.law_not_of_this(left.span, element.kind, left.span.text, ["e[1] = .."])]
            )
        return (self.world.whole(index, element.env, "an index", 1, width),)

    def _law_value(
        self,
        element: Element,
        equation: syntax.LawEquation,
        left: str,
        allowed: Sequence[str],
    ) -> Value:
        """The right side, with the element's variables; the wrong ones are refused by name."""
        two_port = len(allowed[0]) == 2
        own = ("e1", "f1", "e2", "f2") if two_port else ("e", "f", "p", "q")
        # Other paths may lead to the same bond (`body.p` in a law): only bare names are meant.
        bare = set(names_in(equation.right))
        for name in own:
            if name not in bare:
                continue
            if isinstance(find_member(element.env, name), Quantity):
                raise BgError([messages.law_variable_is_a_name(equation.right.span, name)])
            if name not in allowed:
                raise BgError(
                    [
                        messages.law_variable_misplaced(
                            equation.right.span, element.kind, left, name, allowed[0]
                        )
                    ]
                )
        extra = {name: self._law_variable(element, name) for name in allowed}
        return self.world.evaluate(equation.right, element.env, extra)

    def _law_variable(self, element: Element, name: str) -> Value:
        if name in {"q", "p"}:
            return self.values.storage(element, name)
        if len(name) == 2:
            return self.values.variable(element.faces["in" if name[1] == "1" else "out"], name[0])
        face = element.faces.get("all") or element.faces["in"]
        return self.values.variable(face, name)

    # --- arguments ------------------------------------------------------------------

    def _evaluate(self, element: Element, argument: syntax.Argument) -> Value:
        return self.world.evaluate(argument.value, element.env)

    def _missing(self, element: Element) -> BgError:
        way = _WAYS[element.basic]
        return BgError([messages.law_missing(element.span, element.path, element.kind, way)])

    def _one_way(self, element: Element, given: dict[str, syntax.Argument]) -> None:
        if element.law is not None and "ratio" in given:
            raise BgError([messages.law_and_argument(given["ratio"].span, element.path, "ratio")])

    def _check_unit(
        self, element: Element, name: str, value: Value, argument: syntax.Argument
    ) -> None:
        kind = name[0]
        face = element.faces["all"]
        stored = kind in {"q", "p"}
        own = self.values.storage(element, kind) if stored else self.values.variable(face, kind)
        if value.is_scalar:
            value = Value(own.shape, value.nodes * len(own.nodes), value.units * len(own.nodes))
        for component, unit in zip(value.components, own.units, strict=False):
            what = f"`{name}` of `{element.path}`"
            self.world.quantities.check_units(component, unit, argument.span, what)

    def _spread(
        self, element: Element, value: Value, face: Face, span: Span | None = None
    ) -> tuple[Node, ...]:
        """One node for each component; a scalar stands for all."""
        return self._vector(element, element.path, value, _width(face), span or element.use.span)

    def _vector(
        self, element: Element, what: str, value: Value, width: int, span: Span
    ) -> tuple[Node, ...]:
        zero = value.nodes == (self.world.dag.zero,)
        if len(value.nodes) == width and (len(value.shape) < 2 or width == 1):
            return value.nodes
        if value.is_scalar and (zero or what == element.path):
            return value.nodes * width
        expected = f"a vector of {width}" if width > 1 else "a scalar"
        raise BgError(
            [messages.wrong_matrix(span, f"`{what}`", expected, describe_shape(value.shape))]
        )

    def _square(self, element: Element, value: Value, span: Span) -> Matrix:
        """An n x n matrix: of a scalar or vector its diagonal."""
        width = _width(element.faces["all"])
        zero = self.world.dag.zero
        if len(value.shape) == 2:
            return self._matrix(element, value, width, width, span)
        nodes = self._spread(element, value, element.faces["all"], span)
        return tuple(
            tuple(nodes[i] if i == j else zero for j in range(width)) for i in range(width)
        )

    def _matrix(
        self, element: Element, value: Value, rows: int, columns: int, span: Span
    ) -> Matrix:
        if value.shape != (rows, columns):
            expected = f"a {rows} x {columns} matrix"
            found = describe_shape(value.shape)
            raise BgError(
                [messages.wrong_matrix(span, f"the law of `{element.path}`", expected, found)]
            )
        return value.rows

    # --- what a law depends on ------------------------------------------------------

    def _check_modulated(self, element: Element, values: Sequence[Value]) -> None:
        if element.kind in {"TF", "GY"} and any(
            level_of(self.world, value) > Level.PARAM for value in values
        ):
            raise BgError([messages.modulated(element.use.span, element.path, element.kind)])

    def _check_modulated_nodes(self, element: Element, nodes: Sequence[Node]) -> None:
        level = self.world.dag.level
        if element.kind in {"TF", "GY"} and any(level[n] > Level.PARAM for n in nodes):
            raise BgError([messages.modulated(element.use.span, element.path, element.kind)])

    def _depends(self, law: Law, element: Element, own: set[Kind]) -> bool:
        """Whether a law varies by anything but the element's own variables of these kinds."""
        dag = self.world.dag
        match law:
            case LinearLaw():
                return any(dag.level[n] > Level.PARAM for row in law.matrix for n in row)
            case ExplicitLaw():
                roots = law.nodes
            case EnergyLaw():
                roots = (law.energy,)
        allowed: set[tuple[Kind, int]] = set()
        for k, ports in enumerate(self.scalars.ports(element.faces["all"])):
            for kind in own:
                stored = kind in {Kind.DISPLACEMENT, Kind.MOMENTUM}
                allowed.add((kind, element.first_state + k if stored else ports[0].bond))
        for node in dag.reachable(roots):
            symbol = dag.symbol_of(node)
            if symbol is None or symbol.kind is Kind.PARAM:
                continue
            if (symbol.kind, symbol.index) not in allowed:
                return True
        return False

    def _numbers(self, nodes: Sequence[Node]) -> list[float]:
        """The nodes at parameters' defaults and random values of everything else."""
        dag = self.world.dag
        generator = random.Random(20130527)
        leaves = {}
        parameters = self.world.quantities.parameters
        reached = dag.reachable([*nodes, *(p.value for p in parameters)])
        for node in reached:
            symbol = dag.symbol_of(node)
            if symbol is not None:
                leaves[symbol] = generator.uniform(0.1, 0.9)
        for parameter in parameters:
            symbol = dag.symbol_of(dag.symbol(Kind.PARAM, parameter.index))
            assert symbol is not None
            (leaves[symbol],) = evaluate_nodes(dag, [parameter.value], leaves)
        return evaluate_nodes(dag, nodes, leaves)

    # --- ports ----------------------------------------------------------------------

    def _components(self, element: Element, face: Face) -> Iterator[tuple[str, list[Port]]]:
        """The name and ports of each component of an element that falls into scalar ones."""
        found = self.scalars.ports(face)
        for k, ports in enumerate(found):
            yield (f"{element.path}[{k + 1}]" if len(found) > 1 else element.path), ports

    def _pairs(
        self, element: Element, nodes: Sequence[Node]
    ) -> Iterator[tuple[str, Port, Port, Node]]:
        ports1, ports2 = self._two_sides(element)
        width = len(ports1)
        if len(ports2) != width:
            raise BgError([messages.widths_differ(element.span, width, None, len(ports2), None)])
        for k in range(width):
            name = f"{element.path}[{k + 1}]" if width > 1 else element.path
            yield name, ports1[k], ports2[k], nodes[k]

    def _two_sides(self, element: Element) -> tuple[tuple[Port, ...], tuple[Port, ...]]:
        into = tuple(found[0] for found in self.scalars.ports(element.faces["in"]))
        out = tuple(found[0] for found in self.scalars.ports(element.faces["out"]))
        return into, out


def _width(face: Face) -> int:
    width = face.net.root().width
    assert width is not None
    return width.size


def _left_name(equation: syntax.LawEquation) -> str:
    """The variable on the left side, of `e[1]` the `e`; empty when it is none."""
    match equation.left:
        case syntax.Name(name=name):
            return name
        case syntax.Index(base=syntax.Name(name=name)):
            return name
        case _:
            return ""


def _transposed(matrix: Matrix) -> Matrix:
    return tuple(zip(*matrix, strict=True))


def _arguments(element: Element, allowed: tuple[str, ...]) -> dict[str, syntax.Argument]:
    """The arguments by name; one without a name is the first that is allowed."""
    found: dict[str, syntax.Argument] = {}
    problems = []
    for k, argument in enumerate(element.use.arguments):
        name = argument.name
        if name is None and k == 0 and allowed:
            name = allowed[0]
        if name is None:
            problems.append(names.positional_argument(argument.span, f"a {element.kind}", allowed))
        elif name not in allowed:
            if name in {"q0", "p0", "e0", "f0"}:
                have = _INITIAL.get(element.basic, ())
                problems.append(
                    messages.initial_not_of_this(argument.span, name, f"a {element.kind}", have)
                )
            else:
                problems.append(
                    names.unknown_argument(argument.span, name, f"a {element.kind}", allowed)
                )
        elif name in found:
            problems.append(names.given_twice(argument.span, name, found[name].span))
        else:
            found[name] = argument
    if problems:
        raise BgError(problems)
    return found


def _refuse_arguments(element: Element, allowed: tuple[str, ...]) -> None:
    _arguments(element, allowed)


def value_argument(element: Element) -> tuple[str, syntax.Argument] | None:
    """The argument that is an element's law or value, with its name, for its units."""
    names_of = (*_ARGUMENTS.get(element.basic, {}), *filter(None, [_VALUE.get(element.basic)]))
    for k, argument in enumerate(element.use.arguments):
        name = argument.name or (names_of[0] if k == 0 and names_of else None)
        if name in names_of:
            assert name is not None
            return name, argument
    return None
