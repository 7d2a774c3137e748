"""Names that are declared or built in: symbols, and the members of models, ports and devices."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from enum import Enum
from typing import TypeAlias

from bgc.diagnostics.source import Span
from bgc.editing.cursor_tokens import Words
from bgc.grammar import syntax
from bgc.language.elements import ELEMENTS
from bgc.language.scene_tables import DEVICE_COMMANDS, DEVICE_INPUTS
from bgc.record_class import dataclass
from bgc.resolution.modules import Declared, Module, flatten


class Kind(Enum):
    """The kind of thing that a name stands for, in the user's words."""

    MODEL = "model"
    INTERFACE = "interface"
    DOMAIN = "domain"
    FUNCTION = "function"
    SCENE = "scene"
    MODULE = "module"
    VALUE = "value"
    PORT = "port"
    PART = "part"
    DIMENSION = "dimension"
    ARGUMENT = "argument"
    LOOP = "loop variable"
    DEVICE = "device"
    QUANTITY = "quantity of a domain"
    COLUMN = "observed name"
    ELEMENT = "element"
    BUILTIN = "built-in function"
    READABLE = "variable"
    OPTION = "option"


Node: TypeAlias = (
    syntax.Declaration
    | syntax.Value
    | syntax.Port
    | syntax.Part
    | syntax.Formal
    | syntax.For
    | syntax.Device
    | syntax.DomainVariable
    | syntax.Observe
)


@dataclass(frozen=True, slots=True, eq=False)
class Symbol:
    """A name with its declaration.

    `span` is the place of the name in its declaration, `node` the declaration, `module` the file
    in which its types are resolved; None for what is built in. `root` is the place of the name in
    the topmost model or interface that declares the member: a part and the member of the interface
    that it implements are one symbol. `owner` is the model, scene or domain of a member.
    """

    kind: Kind
    name: str
    span: Span | None = None
    node: Node | None = None
    module: Module | None = None
    root: Span | None = None
    owner: str = ""

    @property
    def key(self) -> tuple[str, object]:
        """Equal for all occurrences of one symbol."""
        place = self.root or self.span
        return (place.source.name, place.start) if place else (self.name, self.kind)

    @property
    def doc(self) -> str:
        """The doc comment of the declaration."""
        return getattr(self.node, "doc", "")


Members: TypeAlias = Mapping[str, Symbol]

ALWAYS: Members = {name: Symbol(Kind.READABLE, name) for name in ("time", "pi")}
"""Names that are known in every expression."""


def declared_symbol(declared: Declared[syntax.Declaration]) -> Symbol:
    """Return the symbol of a declaration of a file."""
    node = declared.syntax
    return Symbol(kind_of(node), node.name, node.name_span, node, declared.module)


def kind_of(node: syntax.Declaration) -> Kind:
    """Return the kind of a declaration of a file."""
    match node:
        case syntax.Model():
            return Kind.INTERFACE if node.interface else Kind.MODEL
        case syntax.Domain():
            return Kind.DOMAIN
        case syntax.Function():
            return Kind.FUNCTION
        case syntax.Scene():
            return Kind.SCENE
        case syntax.Value():
            return Kind.VALUE


def scene_symbol(scene: syntax.Scene, module: Module) -> Symbol:
    """Return the symbol of a scene."""
    return Symbol(Kind.SCENE, scene.name, scene.name_span, scene, module)


def lineage(declared: Declared[syntax.Model]) -> list[Declared[syntax.Model]]:
    """Return a model with its base models, nearest first, as far as they are known."""
    found = [declared]
    seen = {id(declared.syntax)}
    while (base := found[-1].syntax.base) is not None:
        above = found[-1].module.models.get(base.name)
        if above is None or id(above.syntax) in seen:
            break
        seen.add(id(above.syntax))
        found.append(above)
    return found


class Table:
    """The members of models, domains and devices of some modules, computed once each."""

    def __init__(self, words: Mapping[str, Words]) -> None:
        self.words = words
        self._members: dict[int, dict[str, Symbol]] = {}
        self._kept: list[object] = []  # what the ids above belong to

    def members(self, declared: Declared[syntax.Model]) -> dict[str, Symbol]:
        """The values, ports, parts and dimensions of a model, inherited ones included."""
        found = self._members.get(id(declared))
        if found is None:
            found = {}
            for each in reversed(lineage(declared)):
                for symbol in _own_members(each):
                    above = found.get(symbol.name)
                    root = symbol.span if above is None else above.root
                    found[symbol.name] = Symbol(
                        symbol.kind,
                        symbol.name,
                        symbol.span,
                        symbol.node,
                        each.module,
                        root,
                        each.syntax.name,
                    )
            self._members[id(declared)] = found
            self._kept.append(declared)
        return found

    def quantities(self, declared: Declared[syntax.Domain]) -> dict[str, Symbol]:
        """The efforts, flows and signals of a domain."""
        found = {}
        words = self.words.get(declared.syntax.span.source.name)
        for variable in declared.syntax.variables:
            span = words.name_after(variable.span.start, variable.name) if words else None
            found[variable.name] = Symbol(
                Kind.QUANTITY,
                variable.name,
                span,
                variable,
                declared.module,
                owner=declared.syntax.name,
            )
        return found

    def inside(
        self, symbol: Symbol, fills: Sequence[tuple[syntax.TypeUse, Module]] = ()
    ) -> Members:
        """The names that may follow a symbol and a dot; `fills` are types that a scene puts in."""
        match symbol.node:
            case syntax.Part() as part:
                assert symbol.module is not None
                uses = [*fills, *((u, symbol.module) for u in (part.default, part.type) if u)]
                found: dict[str, Symbol] = {}
                for use, module in uses:
                    for name, member in self.of_type(use.name, module).items():
                        found.setdefault(name, member)
                return found
            case syntax.Port() as port:
                found = {name: Symbol(Kind.READABLE, name) for name in ("e", "f", "power")}
                domain = symbol.module.domains.get(port.domain or "") if symbol.module else None
                return found | (self.quantities(domain) if domain is not None else {})
            case syntax.Device():
                names = (*DEVICE_INPUTS, *DEVICE_COMMANDS)
                return {name: Symbol(Kind.READABLE, name) for name in names}
            case syntax.Value(dims=dims) | syntax.DomainVariable(dims=dims) if dims:
                return {name: Symbol(Kind.READABLE, name) for name in "xyz"}
            case _:
                return {}

    def of_type(self, name: str, module: Module) -> Members:
        """The names inside a part of a type."""
        declared = module.models.get(name)
        if declared is not None:
            return self.members(declared)
        if name in ELEMENTS:
            return {v: Symbol(Kind.READABLE, v) for v in ELEMENTS[name].observed}
        return {}

    def arguments(self, name: str, module: Module) -> Members:
        """The names of the arguments of a type."""
        declared = module.models.get(name)
        if declared is not None:
            return {n: s for n, s in self.members(declared).items() if _is_argument(s)}
        if name in ELEMENTS:
            return {
                a.name: Symbol(Kind.OPTION, a.name, owner=name) for a in ELEMENTS[name].arguments
            }
        return {}


def type_symbol(name: str, module: Module) -> Symbol | None:
    """Return the model, interface, element or domain of a name."""
    declared = module.models.get(name) or module.domains.get(name)
    if declared is not None:
        return declared_symbol(declared)  # type: ignore[arg-type]
    return Symbol(Kind.ELEMENT, name) if name in ELEMENTS else None


def is_slot(symbol: Symbol) -> bool:
    """Return whether a part can be filled with another type."""
    node = symbol.node
    if not isinstance(node, syntax.Part) or symbol.module is None:
        return False
    declared = symbol.module.models.get(node.type.name)
    return node.default is not None or (declared is not None and declared.syntax.interface)


def _is_argument(symbol: Symbol) -> bool:
    node = symbol.node
    if isinstance(node, syntax.Value):
        return node.kind in {"param", "const", "input"}
    return isinstance(node, syntax.Part) and is_slot(symbol)


def _own_members(declared: Declared[syntax.Model]) -> Iterator[Symbol]:
    for formal in declared.syntax.formals:
        place = Span(formal.span.source, formal.span.start, formal.span.start + len(formal.name))
        yield Symbol(Kind.DIMENSION, formal.name, place, formal)
    for item in flatten(declared.syntax.items):
        match item:
            case syntax.Value():
                yield Symbol(Kind.VALUE, item.name, item.name_span, item)
            case syntax.Port():
                yield Symbol(Kind.PORT, item.name, item.name_span, item)
            case syntax.Part():
                yield Symbol(Kind.PART, item.name, item.name_span, item)
            case _:
                pass
