"""Every place of a file where a name stands, with the symbol that it means."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from bgc.diagnostics.source import Span
from bgc.editing.cursor_tokens import Words
from bgc.editing.symbols import (
    ALWAYS,
    Kind,
    Members,
    Symbol,
    Table,
    declared_symbol,
    is_slot,
    scene_symbol,
    type_symbol,
)
from bgc.grammar import syntax
from bgc.grammar.scene_statements import expressions_in, statement_of
from bgc.language.scene_tables import ACCOUNTS
from bgc.record_class import dataclass
from bgc.resolution.modules import Module, WholeScene
from bgc.resolution.scene_inheritance import text_of
from bgc.values.functions import BUILTINS

_LAW: Members = {
    name: Symbol(Kind.READABLE, name) for name in ("e", "f", "p", "q", "e1", "f1", "e2", "f2", "H")
}
_ACCOUNTS: Members = {"energy": Symbol(Kind.READABLE, "energy")}
_ENERGY: Members = {name: Symbol(Kind.READABLE, name) for name in ACCOUNTS}


@dataclass(frozen=True, slots=True)
class Occurrence:
    """A name at a place; `symbol` is None where it is not declared."""

    span: Span
    symbol: Symbol | None


@dataclass(slots=True)
class Region:
    """The names that are visible in a model or scene, and what a scene puts into slots."""

    names: dict[str, Symbol]
    module: Module
    fills: Mapping[str, syntax.TypeUse]

    def with_names(self, more: Members) -> Region:
        """Return the region with further names."""
        return Region({**self.names, **more}, self.module, self.fills)


def file_region(module: Module) -> Region:
    """Return the constants and parameters of a file and its imports."""
    values = {name: declared_symbol(d) for name, d in module.constants.items()}  # type: ignore[arg-type]
    return Region({**ALWAYS, **values}, module, {})


def model_region(model: syntax.Model, module: Module, table: Table) -> Region:
    """Return the names that are visible in a model."""
    region = file_region(module)
    declared = module.models.get(model.name)
    return region if declared is None else region.with_names(table.members(declared))


def scene_region(scene: syntax.Scene, module: Module, table: Table) -> Region:
    """Return the names that are visible in a scene: members of its model, its devices."""
    region = file_region(module)
    whole = _whole(scene, module)
    use = whole.model if whole is not None else scene.model
    items = whole.items if whole is not None else scene.items
    declared = module.models.get(use.name) if use is not None else None
    members = {} if declared is None else table.members(declared)
    devices = {
        item.name: Symbol(
            Kind.DEVICE,
            item.name,
            _device_name(item, table),
            item,
            module,
        )
        for item in items
        if isinstance(item, syntax.Device)
    }
    fills = {text_of(item.slot): item.type for item in items if isinstance(item, syntax.Use)}
    return Region({**region.names, **members, **devices}, module, fills)


def _device_name(item: syntax.Device, table: Table) -> Span | None:
    words = table.words.get(item.span.source.name)
    return words.name_after(item.span.start, item.name) if words else None


def _whole(scene: syntax.Scene, module: Module) -> WholeScene | None:
    return next((w for w in module.scenes if w.declaration is scene), None)


def occurrences(module: Module, table: Table) -> tuple[Occurrence, ...]:
    """Return the names of a file in the order of the text."""
    walk = _Walk(module, table)
    walk.file()
    unique = {(o.span.start, o.span.end): o for o in walk.found}
    return tuple(sorted(unique.values(), key=lambda o: o.span.start))


class _Walk:
    """Walks the syntax tree of one file and notes each name."""

    def __init__(self, module: Module, table: Table) -> None:
        self.module = module
        self.table = table
        self.found: list[Occurrence] = []
        self._words = table.words.get(module.file.source.name) or Words(module.file.source, ())

    # --- notes ------------------------------------------------------------------------

    def _note(self, span: Span | None, symbol: Symbol | None) -> None:
        if span is not None:
            self.found.append(Occurrence(span, symbol))

    def _name_note(self, start: int, name: str, symbol: Symbol | None) -> None:
        self._note(self._words.name_after(start, name), symbol)

    def _head(self, span: Span, name: str) -> Span:
        """The place of a name at the beginning of a span."""
        return Span(span.source, span.start, span.start + len(name))

    # --- declarations -----------------------------------------------------------------

    def file(self) -> None:
        for item in self.module.file.imports:
            if isinstance(item, syntax.ImportModule):
                name = ".".join(item.path)
                first = self._words.name_after(item.span.start, item.path[0])
                if first is not None:
                    end = self.module.file.source.text.find(";", first.start, item.span.end)
                    place = Span(first.source, first.start, item.span.end if end < 0 else end)
                    self._note(place, Symbol(Kind.MODULE, name))
            else:
                self._note(item.span, Symbol(Kind.MODULE, f'"{item.path}"'))
        region = file_region(self.module)
        for declaration in self.module.file.declarations:
            match declaration:
                case syntax.Model():
                    self._model(declaration)
                case syntax.Scene():
                    self._scene(declaration)
                case syntax.Value():
                    declared = self.module.constants.get(declaration.name)
                    self._note(declaration.name_span, declared and declared_symbol(declared))  # type: ignore[arg-type]
                    self._value(declaration, region)
                case syntax.Function():
                    self._function(declaration, region)
                case syntax.Domain():
                    self._domain(declaration, region)

    def _model(self, model: syntax.Model) -> None:
        declared = self.module.models.get(model.name)
        self._note(model.name_span, declared and declared_symbol(declared))  # type: ignore[arg-type]
        region = model_region(model, self.module, self.table)
        for formal in model.formals:
            symbol = region.names.get(formal.name)
            self._note(self._head(formal.span, formal.name), symbol)
            self._all((formal.default,), region)
        if model.base is not None:
            self._type_use(model.base, region)
        self._items(model.items, region)

    def _function(self, function: syntax.Function, region: Region) -> None:
        declared = self.module.functions.get(function.name)
        self._note(function.name_span, declared and declared_symbol(declared))  # type: ignore[arg-type]
        own = {}
        for formal in function.formals:
            place = self._head(formal.span, formal.name)
            own[formal.name] = symbol = Symbol(
                Kind.ARGUMENT, formal.name, place, formal, self.module, owner=function.name
            )
            self._note(place, symbol)
        self._all((function.body,), region.with_names(own))

    def _domain(self, domain: syntax.Domain, region: Region) -> None:
        declared = self.module.domains.get(domain.name)
        if declared is None:
            return
        self._note(domain.name_span, declared_symbol(declared))  # type: ignore[arg-type]
        quantities = self.table.quantities(declared)
        for variable in domain.variables:
            symbol = quantities[variable.name]
            self._note(symbol.span, symbol)
            self._all(variable.dims, region)

    # --- models -----------------------------------------------------------------------

    def _items(self, items: Iterable[syntax.Item], region: Region) -> None:
        for item in items:
            self._item(item, region)

    def _item(self, item: syntax.Item, region: Region) -> None:
        match item:
            case syntax.Value():
                self._note(item.name_span, region.names.get(item.name))
                self._value(item, region)
            case syntax.Port():
                symbol = region.names.get(item.name)
                self._note(item.name_span, symbol)
                self._all((*item.dims, item.period, *(law.right for law in item.law or ())), region)
                if item.domain is not None:
                    start = max((item.name_span.end, *(d.span.end for d in item.dims)))
                    self._name_note(start, item.domain, type_symbol(item.domain, self.module))
            case syntax.Part():
                self._part(item, region)
            case syntax.Chain():
                self._all((end for stop in item.stops for end in stop), region)
            case syntax.Assign() | syntax.Derivative() | syntax.Project() | syntax.Next():
                self._all((item.target, item.value), region)
            case syntax.Equation():
                self._all((item.left, item.right), region)
            case syntax.Assert():
                self._all((item.condition,), region)
            case syntax.Shape():
                self._note(item.kind_span, Symbol(Kind.OPTION, item.kind))
                self._all((*(a.value for a in item.arguments), *(item.ends or ())), region)
                self._all((item.at, item.axes), region)
            case syntax.Sample():
                self._all((item.period, item.offset), region)
                self._items(item.items, region)
            case syntax.When():
                self._all((item.condition,), region)
                for reset in item.resets:
                    self._all((reset.target, reset.value), region)
            case syntax.For():
                self._all((item.first, item.last), region)
                place = self._words.name_after(item.span.start, item.variable)
                loop = Symbol(Kind.LOOP, item.variable, place, item, self.module)
                self._note(place, loop)
                self._items(item.items, region.with_names({item.variable: loop}))
            case syntax.If():
                self._all((item.condition,), region)
                self._items((*item.yes, *item.no), region)

    def _value(self, value: syntax.Value, region: Region) -> None:
        self._all((*value.dims, *(value.range or ()), value.value), region)

    def _part(self, part: syntax.Part, region: Region) -> None:
        self._note(part.name_span, region.names.get(part.name))
        self._all(part.index, region)
        # The arguments of a slot go to the model that fills it, whatever its interface declares.
        default = part.default
        filling = self.table.arguments(default.name, self.module) if default else None
        self._type_use(part.type, region, filling)
        if part.default is not None:
            self._type_use(part.default, region)
        law = region.with_names(_LAW)
        for equation in part.law or ():
            self._all((equation.left, equation.right), law)

    def _type_use(
        self, use: syntax.TypeUse, region: Region, further: Members | None = None
    ) -> None:
        """Note the names of a use; `further` are arguments beside those of its type."""
        self._note(use.name_span, type_symbol(use.name, self.module))
        self._all(use.dims, region)
        members = {**(further or {}), **self.table.arguments(use.name, self.module)}
        for argument in use.arguments:
            target = members.get(argument.name) if argument.name else None
            if argument.name is not None:
                self._note(self._head(argument.span, argument.name), target)
            self._argument(argument.value, region, target)

    def _argument(self, value: syntax.Expr, region: Region, target: Symbol | None) -> None:
        """Note the names of an argument: an expression, or a type where it fills a slot."""
        fills = target is not None and is_slot(target)
        match value:
            case syntax.TypeUse():
                self._type_use(value, region)
            case syntax.Name(name=name) if fills:
                self._note(value.span, type_symbol(name, self.module))
            case syntax.Index(base=syntax.Name(name=name, span=span)) if fills:
                self._note(span, type_symbol(name, self.module))
                self._all(value.indices, region)
            case syntax.Call(function=name) if fills:
                self._note(self._head(value.span, name), type_symbol(name, self.module))
                self._all(value.arguments, region)
                members = self.table.arguments(name, self.module)
                for option, inner in value.named:
                    self._name_note(value.span.start, option, members.get(option))
                    self._argument(inner, region, members.get(option))
            case _:
                self._all((value,), region)

    # --- scenes -----------------------------------------------------------------------

    def _scene(self, scene: syntax.Scene) -> None:
        self._note(scene.name_span, scene_symbol(scene, self.module))
        region = scene_region(scene, self.module, self.table)
        if scene.base is not None:
            self._note(scene.base.span, self._base_scene(scene.base.name))
        if scene.model is not None:
            self._type_use(scene.model, file_region(self.module))
        columns: dict[str, Symbol] = {}
        whole = _whole(scene, self.module)
        for item in whole.items if whole is not None else scene.items:
            if isinstance(item, syntax.Observe) and item.alias is not None:
                words = self.table.words.get(item.span.source.name, self._words)
                place = words.name_after(item.value.span.end, item.alias)
                columns[item.alias] = symbol = Symbol(
                    Kind.COLUMN, item.alias, place, item, self.module, owner=scene.name
                )
                if item.span.source is scene.span.source:
                    self._note(place, symbol)
        for item in scene.items:
            self._scene_item(item, region, columns)

    def _base_scene(self, name: str) -> Symbol | None:
        own = next((s for s in self.module.scene_declarations if s.name == name), None)
        if own is not None:
            return scene_symbol(own, self.module)
        seen = self.module.seen_scenes.get(name)
        return scene_symbol(seen[0].declaration, self.module) if seen else None

    def _scene_item(self, item: syntax.SceneItem, region: Region, columns: Members) -> None:
        if isinstance(item, syntax.Device):
            place = self._words.name_after(item.span.start, item.name)
            self._note(place, region.names.get(item.name))
        shown = region.with_names(columns) if statement_of(item).names_columns else region
        self._all(expressions_in(item), shown)

    # --- expressions ------------------------------------------------------------------

    def _all(
        self, expressions: Iterable[syntax.Expr | syntax.Range | None], region: Region
    ) -> None:
        for expression in expressions:
            if expression is not None:
                self._expression(expression, region)

    def _expression(self, expr: syntax.Expr | syntax.Range, region: Region) -> None:
        match expr:
            case syntax.Name():
                self._note(expr.span, resolve(expr, region, self.table))
            case syntax.Member():
                self._expression(expr.base, region)
                span = Span(expr.span.source, expr.span.end - len(expr.name), expr.span.end)
                self._note(span, resolve(expr, region, self.table))
            case syntax.Index():
                self._all((expr.base, *expr.indices), region)
            case syntax.Range():
                self._all((expr.first, expr.last), region)
            case syntax.Call():
                self._note(self._head(expr.span, expr.function), self._called(expr.function))
                self._all(expr.arguments, region)
                for _, method in expr.named:
                    self._note(method.span, Symbol(Kind.OPTION, method.span.text))
            case syntax.Unary():
                self._expression(expr.operand, region)
            case syntax.Binary():
                self._all(expr.operands(), region)
            case syntax.Conditional():
                self._all((expr.condition, expr.yes, expr.no), region)
            case syntax.Vector():
                self._all(expr.elements, region)
            case syntax.TypeUse():
                self._type_use(expr, region)
            case syntax.Number() | syntax.Text():
                pass

    def _called(self, name: str) -> Symbol | None:
        declared = self.module.functions.get(name)
        if declared is not None:
            return declared_symbol(declared)  # type: ignore[arg-type]
        return Symbol(Kind.BUILTIN, name) if name in BUILTINS or name == "der" else None


def resolve(expr: syntax.Expr, region: Region, table: Table) -> Symbol | None:
    """Return the symbol that a path means: `crane.boom.mass`, `mass[2].p`."""
    match expr:
        case syntax.Name():
            return region.names.get(expr.name) or _ACCOUNTS.get(expr.name)
        case syntax.Index():
            return resolve(expr.base, region, table)
        case syntax.Member():
            return members_at(expr.base, region, table).get(expr.name)
        case _:
            return None


def members_at(expr: syntax.Expr, region: Region, table: Table) -> Members:
    """Return the names that may follow a path and a dot."""
    symbol = resolve(expr, region, table)
    if symbol is None:
        return {}
    if symbol is _ACCOUNTS["energy"]:
        return _ENERGY
    fill = region.fills.get(text_of(expr))
    return table.inside(symbol, [(fill, region.module)] if fill is not None else [])
