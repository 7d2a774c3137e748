"""Read sources, storage elements and resistors from their arguments and law blocks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from bgc.algebra.dag import Kind, Level
from bgc.algebra.linear import linear_coefficients
from bgc.diagnostics.catalogue import laws as law_messages
from bgc.diagnostics.catalogue import shapes as shape_messages
from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.bonds.domains import JOULE
from bgc.elaboration.instances.checks import check_components, check_units, require_level
from bgc.elaboration.instances.components import component_name
from bgc.elaboration.instances.tree import Element
from bgc.elaboration.laws.law_blocks import (
    Laws,
    arguments_of,
    left_name,
    missing_law,
)
from bgc.elaboration.laws.matrix_checks import depends_on_others
from bgc.grammar import syntax
from bgc.ir.graph import (
    EnergyLaw,
    ExplicitLaw,
    Form,
    Initial,
    Law,
    LinearLaw,
    Resistor,
    Source,
    Storage,
)
from bgc.values.units import DIMENSIONLESS
from bgc.values.value import Value, describe_shape

_MAX_PORTS = 1000  # of a multiport element, whose matrix has one row and column per port
_STATE_KINDS = {"q": Kind.DISPLACEMENT, "p": Kind.MOMENTUM}


def read_sources(laws: Laws, element: Element) -> list[Source]:
    """Read a source, with one scalar element per component."""
    variable = element.row.value_argument
    assert variable is not None, "a source has a value"
    given = arguments_of(element, (variable,))
    if variable in given and element.law is not None:
        raise BgError([law_messages.law_and_argument(given[variable].span, element.path, variable)])
    if element.law:
        value = _source_law(laws, element, element.law, variable)
    elif variable in given:
        value = laws.world.evaluate(given[variable].value, element.env)
    else:
        raise missing_law(element)
    ports = laws.ports(element, "all")
    what = f"the value of `{element.path}`"
    nodes = laws.vector(value, len(ports), element.use.span, what, spread=True)
    own = laws.variable(element, variable)
    units = value.units * (len(ports) if value.is_scalar else 1)
    check_components(Value(own.shape, nodes, units), own.units, element.use.span, what)
    return [
        Source(
            component_name(element.path, (k + 1,) if len(ports) > 1 else ()),
            element.basic,
            port,
            node,
            element.span,
        )
        for k, (port, node) in enumerate(zip(ports, nodes, strict=True))
    ]


def _source_law(
    laws: Laws, element: Element, law: Sequence[syntax.LawEquation], variable: str
) -> Value:
    """The value of a source with a law, `Se { e = 5*sin(time); }`."""
    first = law[0]
    if not isinstance(first.left, syntax.Name) or first.left.name != variable:
        text = " ".join(first.left.span.text.split())
        have = [f"{variable} = .."]
        raise BgError([law_messages.law_not_of_this(first.left.span, element.kind, text, have)])
    if len(law) > 1:
        raise BgError([law_messages.law_too_many(law[1].span, element.path, "keep one")])
    return laws.world.evaluate(first.right, element.env)


def read_storage(laws: Laws, element: Element) -> Storage:
    """Read a C, I or IC: one element of any width."""
    kind, row = element.basic, element.row
    given = arguments_of(element, (*row.law_arguments, *row.initial_arguments))
    law = _read_law(laws, element, given)
    if depends_on_others(laws, law, element, {_STATE_KINDS[name] for name in row.stored}):
        raise BgError([law_messages.storage_varies(element.use.span, element.path, kind)])
    initial = read_initials(laws, element, given)
    ports = laws.ports(element, "all")
    return Storage(element.path, kind, ports, law, element.first_state, initial, element.span)


def read_initials(
    laws: Laws, element: Element, given: Mapping[str, syntax.Argument]
) -> tuple[Initial, ...]:
    """The values that an element's arguments give for the start, one per port or component."""
    return tuple(
        start
        for name in element.row.initial_arguments
        if name in given
        for start in _read_initial(laws, element, name, given[name])
    )


def _read_initial(
    laws: Laws, element: Element, name: str, argument: syntax.Argument
) -> list[Initial]:
    """The initial values from an argument `q0`, `p0`, `e0` or `f0`, one per port."""
    value = laws.world.evaluate(argument.value, element.env)
    span, what = argument.span, f"`{name}` of `{element.path}`"
    require_level(laws.world.dag, value, Level.TIME, span, what)
    own = laws.variable(element, name[0])
    nodes = laws.vector(value, len(own.nodes), span, what, spread=True)
    units = value.units if len(value.units) == len(nodes) else value.units * len(nodes)
    check_components(Value(own.shape, nodes, units), own.units, span, what)
    is_default = laws.world.quantities.is_zero_by_default(argument.value, element.env)
    return [Initial(k, name[0], node, span, is_default) for k, node in enumerate(nodes)]


def read_resistor(laws: Laws, element: Element) -> Resistor:
    """Read an R: one element of any width."""
    given = arguments_of(element, tuple(element.row.law_arguments))
    law = _read_law(laws, element, given)
    assert not isinstance(law, EnergyLaw)
    own = {Kind.EFFORT, Kind.FLOW}
    if element.kind == "R" and depends_on_others(laws, law, element, own):
        raise BgError([law_messages.modulated(element.use.span, element.path, "R")])
    return Resistor(element.path, laws.ports(element, "all"), law, element.span)


def _read_law(laws: Laws, element: Element, given: dict[str, syntax.Argument]) -> Law:
    if len(laws.ports(element, "all")) > _MAX_PORTS:
        raise BgError(
            [shape_messages.too_large(element.use.span, f"the matrix of `{element.path}`")]
        )
    forms = element.row.law_arguments
    named = [name for name in forms if name in given]
    if element.law is not None and named:
        raise BgError([law_messages.law_and_argument(given[named[0]].span, element.path, named[0])])
    if len(named) > 1:
        second, first = given[named[1]].span, f"the argument `{named[0]}`"
        raise BgError([law_messages.law_and_argument(second, element.path, named[1], first)])
    if named:
        argument = given[named[0]]
        value = laws.world.evaluate(argument.value, element.env)
        width = len(laws.ports(element, "all"))
        what = f"the {named[0]} of `{element.path}`"
        matrix = laws.square(value, width, argument.span, what)
        form = forms[named[0]]
        law = next(law for law in element.row.laws if law.form is form)
        laws.check_entries(element, value, law.left, law.right, argument.span, what)
        return LinearLaw(form, matrix)
    if not element.law:
        raise missing_law(element)
    if left_name(element.law[0]) == "H" and element.row.energy:
        return _read_energy(laws, element, element.law)
    return _read_equation(laws, element, element.law)


def _read_energy(laws: Laws, element: Element, law: Sequence[syntax.LawEquation]) -> EnergyLaw:
    if len(law) > 1:
        raise BgError([law_messages.law_too_many(law[1].span, element.path, "keep one")])
    value = laws.right_side(element, law[0], "H", element.row.energy)
    if len(value.nodes) != 1:
        found = describe_shape(value.shape)
        raise BgError([law_messages.wrong_matrix(law[0].right.span, "`H`", "a scalar", found)])
    plain = value.units == (DIMENSIONLESS,) and set(laws.variable(element, "e").units) == {None}
    powers = all(laws.values.is_power(port.bond) for port in laws.ports(element, "all"))
    if powers and not plain:  # a plain number fits bonds without units
        at = law[0].right.span
        check_units(value, JOULE, at, f"`H` of `{element.path}`")
    return EnergyLaw(value.node)


def _read_equation(laws: Laws, element: Element, law: Sequence[syntax.LawEquation]) -> Law:
    have = [f"{left} = .." for left in element.row.law_starts]
    left, nodes = laws.equations(element, law, element.row.right_sides, have)
    (variable, form) = next((law.right, law.form) for law in element.row.laws if law.left == left)
    assert form is not None, "a law of a one-port has a form"
    symbols = laws.variable(element, variable).nodes
    matrix = linear_coefficients(laws.world.dag, nodes, symbols)
    if matrix is not None:
        return LinearLaw(form, matrix)
    if form in {Form.DISPLACEMENT, Form.MOMENTUM}:
        raise BgError([law_messages.law_not_linear(law[0].span, element.path, variable)])
    return ExplicitLaw(form, nodes)
