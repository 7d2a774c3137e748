"""Check that every plain name in the models of a file is declared.

Of a path only the first name is checked: the others depend on the models that fill the slots, which
are known when a scene is elaborated.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from bgc.diagnostics.catalogue import listed, names, ranges, values
from bgc.diagnostics.collection import Report
from bgc.grammar import syntax
from bgc.grammar.peers import function_advice
from bgc.language.elements import ELEMENTS
from bgc.resolution.modules import Declared, Module, ancestors, flatten
from bgc.values.functions import BUILTINS
from bgc.values.unknown_names import unknown_name

_ALWAYS = {"time", "pi"}
_LAW_VARIABLES = {"e", "f", "p", "q", "e1", "f1", "e2", "f2", "H"}


def check_names(declared: Declared[syntax.Model], report: Report) -> None:
    """Report each undeclared name and function in a model."""
    members = set(_ALWAYS)
    for ancestor in ancestors(declared):
        members.update(formal.name for formal in ancestor.syntax.formals)
        if not ancestor.syntax.interface or ancestor is declared:
            members.update(_declared_names(ancestor.syntax.items))
    checker = _Checker(declared.module, report)
    if declared.syntax.base is not None:
        checker.type_use(declared.syntax.base, members)
    checker.items(declared.syntax.items, members)


def _declared_names(items: tuple[syntax.Item, ...]) -> Iterator[str]:
    for item in flatten(items):
        match item:
            case syntax.Value() | syntax.Port() | syntax.Part():
                yield item.name
            case _:
                pass


class _Checker:
    """Walks the statements of one model; `seen` are the names visible at each."""

    def __init__(self, module: Module, report: Report) -> None:
        self._module = module
        self._report = report
        self._in_law = ""  # help about an unknown name in the law that is walked

    def items(self, items: tuple[syntax.Item, ...], seen: set[str]) -> None:
        for item in items:
            match item:
                case syntax.Value():
                    ends = item.range or ()
                    if ends and item.kind not in {"param", "const"}:
                        span = ends[0].span.to(ends[1].span)
                        self._report.add(ranges.range_of_variable(span, item.name, item.kind))
                    self.all((*item.dims, *ends, *((item.value,) if item.value else ())), seen)
                case syntax.Port():
                    period = () if item.period is None else (item.period,)
                    self.all((*item.dims, *period, *(law.right for law in item.law or ())), seen)
                case syntax.Part():
                    self._part(item, seen)
                case syntax.Chain():
                    self.all((end for stop in item.stops for end in stop), seen)
                case syntax.Assign(
                    target=syntax.Name() as target, value=syntax.Call() as value
                ) if target.name not in seen and self._is_type(value.function):
                    self._report.add(names.part_by_equals(item.span, target.name, value.function))
                case syntax.Assign() | syntax.Derivative() | syntax.Project() | syntax.Next():
                    self.all((item.target, item.value), seen)
                case syntax.Equation():
                    self.all((item.left, item.right), seen)
                case syntax.Assert():
                    self.expression(item.condition, seen)
                case syntax.Shape():
                    places = (*(item.ends or ()), item.at, item.axes)
                    self.all((a.value for a in item.arguments), seen)
                    self.all((place for place in places if place is not None), seen)
                case syntax.Sample():
                    self.all((item.period, *((item.offset,) if item.offset else ())), seen)
                    self.items(item.items, seen)
                case syntax.When():
                    self.expression(item.condition, seen)
                    for reset in item.resets:
                        self.all((reset.target, reset.value), seen)
                case syntax.For():
                    self.all((item.first, item.last), seen)
                    self.items(item.items, {*seen, item.variable})
                case syntax.If():
                    self.expression(item.condition, seen)
                    self.items(item.yes, seen)
                    self.items(item.no, seen)

    def _part(self, part: syntax.Part, seen: set[str]) -> None:
        self.all(part.index, seen)
        for use in (part.type, part.default):
            if use is not None:
                self.type_use(use, seen)
        element = ELEMENTS.get(part.type.name) if part.type is not None else None
        if element is not None and element.law_variables:
            variables = listed(element.law_variables)
            self._in_law = f"the variables of the law are {variables}; declare any other"
        for equation in part.law or ():
            self.all((equation.left, equation.right), {*seen, *_LAW_VARIABLES})
        self._in_law = ""

    def type_use(self, use: syntax.TypeUse, seen: set[str]) -> None:
        self.all(use.dims, seen)
        laws = ELEMENTS[use.name].law_starts if use.name in ELEMENTS else ()
        for argument in use.arguments:
            # A law in parentheses is reported with the other arguments of the element.
            own = _LAW_VARIABLES if argument.name in laws else set()
            self._argument(argument.value, seen | own)

    def _argument(self, value: syntax.Expr, seen: set[str]) -> None:
        """Check an argument: an expression, or a type for a slot (`Rigid[5]`, `Rigid(k = 3)`)."""
        match value:
            case syntax.TypeUse():
                self.type_use(value, seen)
            case (
                syntax.Name(name=name)
                | syntax.Index(base=syntax.Name(name=name))
                | syntax.Call(function=name)
            ) if self._is_type(name):
                pass
            case _:
                self.expression(value, seen)

    def _is_type(self, name: str) -> bool:
        return name in self._module.models or name in ELEMENTS

    def all(self, expressions: Iterable[syntax.Expr | syntax.Range], seen: set[str]) -> None:
        for expression in expressions:
            self.expression(expression, seen)

    def expression(self, expr: syntax.Expr | syntax.Range, seen: set[str]) -> None:
        if self._report.is_full:
            return  # further errors are not shown, and finding similar names is slow
        match expr:
            case syntax.Name():
                if expr.name not in seen and expr.name not in self._module.constants:
                    candidates = sorted([*seen, *self._module.constants])
                    self._report.add(unknown_name(expr, candidates, self._in_law))
            case syntax.Call():
                known = expr.function in BUILTINS
                if not known and expr.function not in self._module.functions:
                    self._unknown_function(expr, seen)
                self.all(expr.arguments, seen)  # the options of `interpolate` name no quantities
            case syntax.Member():
                self.expression(expr.base, seen)
            case syntax.Index():
                self.all((expr.base, *expr.indices), seen)
            case syntax.Range():
                self.all((expr.first, expr.last), seen)
            case syntax.Unary():
                self.expression(expr.operand, seen)
            case syntax.Binary():
                self.all(expr.operands(), seen)
            case syntax.Conditional():
                self.all((expr.condition, expr.yes, expr.no), seen)
            case syntax.Vector():
                self.all(expr.elements, seen)
            case syntax.TypeUse():
                self.type_use(expr, seen)
            case syntax.Number() | syntax.Text():
                pass

    def _unknown_function(self, expr: syntax.Call, seen: set[str]) -> None:
        if expr.function in seen or expr.function in self._module.constants:
            self._report.add(values.called_value(expr.span, expr.function))
            return
        known = (*BUILTINS, *self._module.functions)
        advice = function_advice(expr.function)
        self._report.add(values.unknown_function(expr.span, expr.function, known, advice))
