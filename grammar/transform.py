"""Transform the parse tree into the syntax tree, and report what the grammar is too wide for."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from lark import Token, Tree

from bgc.diagnostics.catalogue import jumps
from bgc.diagnostics.catalogue import syntax as wrong
from bgc.diagnostics.catalogue.inherited_scenes import model_and_base
from bgc.diagnostics.catalogue.ports import law_of_plain_port
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Source, Span
from bgc.grammar import syntax
from bgc.grammar.language_words import SCENE_WORDS
from bgc.grammar.scene_statements import SCENE_STATEMENTS, SceneStatement
from bgc.grammar.tokens import ParseTree
from bgc.grammar.transform_expressions import (
    MAX_DEPTH,
    ExpressionTransform,
    children_of,
    unquoted,
)

_COMMENTS = re.compile(r"/\*.*?\*/")


_TWO_SIDED: Mapping[str, Callable[[syntax.Expr, syntax.Expr, Span], syntax.Item]] = {
    "assign": syntax.Assign,
    "derivative": syntax.Derivative,
    "equation": syntax.Equation,
    "project": syntax.Project,
    "next": syntax.Next,
}  # `left = right;`, with or without a keyword


def transform(source: Source, tree: ParseTree) -> tuple[syntax.File, tuple[Diagnostic, ...]]:
    """Make the syntax tree of a file from its parse tree.

    Parts that the language does not allow are reported, and replaced or left out.
    """
    worker = _Transform(source)
    return worker.file(tree), tuple(worker.diagnostics)


def transform_setting(source: Source, tree: ParseTree) -> tuple[syntax.Set, tuple[Diagnostic, ...]]:
    """Make the setting of a parameter, `a.b = value`, from its parse tree."""
    worker = _Transform(source)
    return worker.setting(tree), tuple(worker.diagnostics)


def transform_filling(source: Source, tree: ParseTree) -> tuple[syntax.Use, tuple[Diagnostic, ...]]:
    """Make the filling of a slot, `a.b = Type(.., c = value)`, from its parse tree."""
    worker = _Transform(source)
    return worker.filling(tree), tuple(worker.diagnostics)


class _Transform(ExpressionTransform):
    """The transformation of declarations and items: one method for each rule of the grammar."""

    def file(self, tree: ParseTree) -> syntax.File:
        imports: list[syntax.Import] = []
        declarations: list[syntax.Declaration] = []
        for child in _listed(tree.children[0]):
            if child.data in ("import_file", "import_module"):
                imported = self._import(child)
                if declarations:
                    self.report(wrong.late_import(imported.span))
                imports.append(imported)
            else:
                declarations.append(self._declaration(child))
        return syntax.File(self.source, tuple(imports), tuple(declarations))

    def setting(self, tree: ParseTree) -> syntax.Set:
        return syntax.Set(*self._two_sides(tree))

    def filling(self, tree: ParseTree) -> syntax.Use:
        """Make a `use`, with or without its word and semicolon."""
        *_, slot, filled = tree.children
        return syntax.Use(self.expression(slot), self._type_use(filled), self.span(tree))

    def _import(self, tree: ParseTree) -> syntax.Import:
        span = self.span(tree)
        if tree.data == "import_file":
            return syntax.ImportFile(unquoted(tree.children[1]), span)
        return syntax.ImportModule(tuple(str(name) for name in tree.children[1:]), span)

    def _declaration(self, tree: ParseTree) -> syntax.Declaration:
        match tree.data:
            case "constant" | "world":
                return self._value(tree)
            case "function":
                return self._function(tree)
            case "domain":
                return self._domain(tree)
            case "interface" | "model":
                return self._model(tree)
            case "scene":
                return self._scene(tree)
        raise AssertionError(tree.data)

    # --- declarations ---------------------------------------------------------------------

    def _function(self, tree: ParseTree) -> syntax.Function:
        _, name, formals, body = children_of(tree)
        arguments = self._formals(formals)
        for formal in arguments:
            if formal.default is not None:
                self.report(wrong.default_of_function(formal.span, formal.name))
        return syntax.Function(
            str(name),
            arguments,
            self.expression(body),
            self._doc(tree),
            self.span(tree),
            self.token_span(name),
        )

    def _formals(self, tree: ParseTree | None) -> tuple[syntax.Formal, ...]:
        if tree is None:
            return ()
        formals: list[syntax.Formal] = []
        for child in _trees(tree):
            name, default = children_of(child)
            formals.append(
                syntax.Formal(str(name), self._optional_expression(default), self.span(child))
            )
        return tuple(formals)

    def _domain(self, tree: ParseTree) -> syntax.Domain:
        pseudo, _, name, variables, _ = children_of(tree)
        return syntax.Domain(
            str(name),
            pseudo is not None,
            tuple(self._domain_variable(variable) for variable in _listed(variables)),
            self._doc(tree),
            self.span(tree),
            self.token_span(name),
        )

    def _domain_variable(self, tree: ParseTree) -> syntax.DomainVariable:
        kind, name, dims, unit = children_of(tree)
        return syntax.DomainVariable(
            str(kind), str(name), self._dims(dims), _optional_text(unit), self.span(tree)
        )

    def _model(self, tree: ParseTree) -> syntax.Model:
        _, name, formals, *is_base, block = children_of(tree)
        base = is_base[1] if is_base else None
        return syntax.Model(
            str(name),
            tree.data == "interface",
            self._formals(formals),
            None if base is None else self._type_use(base),
            self._block(block),
            self._doc(tree),
            self.span(tree),
            self.token_span(name),
        )

    def _scene(self, tree: ParseTree) -> syntax.Scene:
        _, name, word, first, _, second, items, _ = children_of(tree)
        model, base = (first, second) if word.type == "OF" else (second, first)
        if model is not None and base is not None:
            self.report(model_and_base(self.span(model), str(name), str(base)))
            base = None
        return syntax.Scene(
            str(name),
            None if model is None else self._type_use(model),
            None if base is None else syntax.Name(str(base), self.token_span(base)),
            tuple(made for item in _listed(items) for made in self._scene_item(item)),
            self._doc(tree),
            self.span(tree),
            self.token_span(name),
        )

    # --- items of a model -----------------------------------------------------------------

    def _block(self, tree: ParseTree) -> tuple[syntax.Item, ...]:
        return tuple(self._item(child) for child in _listed(tree.children[0]))

    def _item(self, tree: ParseTree) -> syntax.Item:
        match tree.data:
            case "value":
                return self._value(tree)
            case "port":
                return self._port(tree)
            case "part":
                return self._part(tree)
            case "chain":
                return self._chain(tree)
            case "assertion":
                return self._assertion(tree)
            case "shape":
                return self._shape(tree)
            case "sample":
                return self._sample(tree)
            case rule if rule in _TWO_SIDED:
                return _TWO_SIDED[rule](*self._two_sides(tree))
            case "when":
                return self._when(tree)
            case "for":
                return self._for(tree)
            case "if":
                return self._if(tree)
        raise AssertionError(tree.data)

    def _two_sides(self, tree: ParseTree) -> tuple[syntax.Expr, syntax.Expr, Span]:
        """Transform `left = right;`, with or without a keyword before it, and return its span."""
        left, right = tree.children[-2:]
        return self.expression(left), self.expression(right), self.span(tree)

    def _value(self, tree: ParseTree) -> syntax.Value:
        kind, name, dims, unit, value, _, first, last = children_of(tree)
        return syntax.Value(
            str(kind),
            str(name),
            self._dims(dims),
            _optional_text(unit),
            self._optional_expression(value),
            None if first is None else (self.expression(first), self.expression(last)),
            self._doc(tree),
            self.span(tree),
            self.token_span(name),
        )

    def _port(self, tree: ParseTree) -> syntax.Port:
        _, name, dims, direction, _, period, domain, main, *law = children_of(tree)
        if law and period is None:
            self.report(law_of_plain_port(self.span(law[0]), str(name)))
        return syntax.Port(
            str(name),
            self._dims(dims),
            None if direction is None else syntax.Direction(str(direction)),
            _optional_text(domain),
            main is not None,
            self._doc(tree),
            self.span(tree),
            self.token_span(name),
            self._optional_expression(period),
            tuple(map(self._law_equation, _listed(law[0].children[1]))) if law else None,
        )

    def _part(self, tree: ParseTree) -> syntax.Part:
        path, type_use, default, *law = children_of(tree)
        name, *suffixes = path.children
        index: tuple[syntax.Expr, ...] = ()
        match suffixes:
            case []:
                pass
            case [Tree(data="indices") as indices]:
                index = self.plain_indices(indices)
            case _:
                self.report(wrong.name_of_part(self.span(path), str(name)))
        if default is not None and law:
            self.report(wrong.slot_with_law(self.span(law[0]), str(name)))
        return syntax.Part(
            str(name),
            index,
            self._type_use(type_use),
            None if default is None else self._type_use(default.children[0]),
            tuple(map(self._law_equation, _listed(law[0].children[1]))) if law else None,
            self._doc(tree),
            self.span(tree),
            self.token_span(name),
        )

    def _law_equation(self, tree: ParseTree) -> syntax.LawEquation:
        return syntax.LawEquation(*self._two_sides(tree))

    def _chain(self, tree: ParseTree) -> syntax.Chain:
        stops = tuple(tuple(self.expression(end) for end in _trees(ends)) for ends in _trees(tree))
        for stop in stops[1:-1]:
            if len(stop) > 1:
                self.report(wrong.list_within_chain(stop[0].span.to(stop[-1].span)))
        return syntax.Chain(stops, self.span(tree))

    def _assertion(self, tree: ParseTree) -> syntax.Assert:
        _, condition, message = children_of(tree)
        return syntax.Assert(self.expression(condition), unquoted(message), self.span(tree))

    def _shape(self, tree: ParseTree) -> syntax.Shape:
        _, kind, _, arguments, _, _, first, _, second, _, at, axes, _, colour = children_of(tree)
        span = self.span(tree)
        return syntax.Shape(
            str(kind),
            self.token_span(kind),
            self.arguments(arguments),
            None if first is None else (self.expression(first), self.expression(second)),
            self._optional_expression(at),
            self._optional_expression(axes),
            None if colour is None else unquoted(colour),
            span if colour is None else self.token_span(colour),
            span,
        )

    def _sample(self, tree: ParseTree) -> syntax.Sample:
        _, period, _, offset, block = children_of(tree)
        return syntax.Sample(
            self.expression(period),
            self._optional_expression(offset),
            self._block(block),
            self.span(tree),
        )

    def _when(self, tree: ParseTree) -> syntax.When:
        word, condition, _, resets, _ = children_of(tree)
        if resets is None:
            self.report(jumps.empty_when(self.token_span(word)))
        made = tuple(syntax.Reset(*self._two_sides(reset)) for reset in _listed(resets))
        return syntax.When(self.expression(condition), made, self.span(tree))

    def _for(self, tree: ParseTree) -> syntax.For:
        _, variable, _, first, last, block = children_of(tree)
        return syntax.For(
            str(variable),
            self.expression(first),
            self.expression(last),
            self._block(block),
            self.span(tree),
        )

    def _if(self, tree: ParseTree) -> syntax.If:
        """Nest the branches of `if a { } else if b { } else { }`, from the last to the first."""
        listed, last_else, last_block = children_of(tree)
        otherwise = () if last_else is None else self._block(last_block)
        branches: list[list[Any]] = [branch.children for branch in _listed(listed)]
        if len(branches) > MAX_DEPTH:
            self.report(wrong.too_deep(self.token_span(branches[MAX_DEPTH][0])))
            del branches[MAX_DEPTH:]
        end = self.span(tree)
        made = None
        for word, condition, block in reversed(branches):
            span = self.token_span(word).to(end)
            made = syntax.If(self.expression(condition), self._block(block), otherwise, span)
            otherwise = (made,)
        assert made is not None
        return made

    # --- items of a scene -----------------------------------------------------------------

    def _scene_item(self, tree: ParseTree) -> list[syntax.SceneItem]:
        """Transform one statement: into several items where it lists several values."""
        children: list[Any] = tree.children
        span = self.span(tree)
        match tree.data:
            case "use":
                return [self.filling(tree)]
            case "set":
                return [self.setting(tree)]
            case "device":
                _, name, driver, arguments = children
                self._refuse_scene_word(name)
                return [syntax.Device(str(name), str(driver), self.arguments(arguments), span)]
            case "drive":
                return [syntax.Drive(*self._two_sides(tree))]
            case "observe":
                return [self._observed(child) for child in children[1:]]
            case "plot":
                *columns, _, against = children[1:]
                drawn = tuple(self.expression(c) for c in columns)
                across = None if against is None else self.expression(against)
                return [syntax.Plot(drawn, across, span)]
            case "require":
                _, value, _, tolerance = children
                within = None if tolerance is None else self.expression(tolerance)
                return [syntax.Require(self.expression(value), within, span)]
            case "keep":
                return [syntax.Keep(self.expression(c), self.span(c)) for c in children[1:]]
            case "solver":
                _, name, arguments = children
                return [syntax.Solver(str(name), self.arguments(arguments), span)]
            case "start":
                return [self._start(tree)]
            case "proof":
                return [syntax.Proof(str(children[1])[1:-1], span)]
        return [self._fact(SCENE_STATEMENTS[tree.data], children, span)]

    def _fact(self, row: SceneStatement, children: list[Any], span: Span) -> syntax.Fact:
        """Take the values and the chosen words from the places that the row names."""
        values: list[syntax.Argument] = []
        for name, place in row.gives.items():
            if (found := children[place]) is not None:
                chosen = syntax.Text(str(found), self.span(found)) if name in row.chooses else None
                value = chosen or self.expression(found)
                values.append(syntax.Argument(name, value, value.span))
        return syntax.Fact(row.word, tuple(values), span)

    def _start(self, tree: ParseTree) -> syntax.Start:
        """Divide the paths behind `start rest` into those after `hold` and those after `vary`."""
        lists: dict[str, list[syntax.Expr]] = {"HOLD": [], "VARY": []}
        word = ""
        for child in children_of(tree)[2:]:
            if isinstance(child, Token):
                word = child.type
            elif child is not None:
                lists[word].append(self.expression(child))
        return syntax.Start(tuple(lists["HOLD"]), tuple(lists["VARY"]), self.span(tree))

    def _observed(self, tree: ParseTree) -> syntax.Observe:
        children: list[Any] = tree.children
        if tree.data == "observed_in":
            value, _, unit, _, alias = children
        else:
            value, _, alias, _, unit = children
        if alias is not None:
            self._refuse_scene_word(alias)
        span = self.span(tree)
        return syntax.Observe(
            self.expression(value),
            _optional_text(alias),
            _optional_text(unit),
            span if unit is None else self.token_span(unit),
            span,
        )

    def _refuse_scene_word(self, name: Token) -> None:
        if str(name) in SCENE_WORDS:
            self.report(wrong.reserved_word(self.token_span(name), str(name)))

    # --- parts of declarations and items ----------------------------------------------------

    def _type_use(self, tree: ParseTree) -> syntax.TypeUse:
        name, dims, _, arguments, _ = children_of(tree)
        return syntax.TypeUse(
            str(name),
            self._dims(dims),
            self.arguments(arguments),
            self.span(tree),
            self.token_span(name),
            keeps=arguments is not None and arguments.data == "kept",
        )

    def _dims(self, tree: ParseTree | None) -> tuple[syntax.Expr, ...]:
        if tree is None:
            return ()
        return tuple(self.expression(child) for child in tree.children[1:-1])

    def _optional_expression(self, tree: ParseTree | Token | None) -> syntax.Expr | None:
        return None if tree is None else self.expression(tree)

    def _doc(self, tree: ParseTree) -> str:
        """Return the text of the `///` lines above a declaration that begins its line.

        Empty lines may stand between; one within the comment parts it from what is above.
        """
        text, starts = self.source.text, self.source.line_starts
        start = self.span(tree).start
        number, column = self.source.position(start)
        if _COMMENTS.sub("", text[start - column + 1 : start]).strip():
            return ""
        lines: list[str] = []
        for above in range(number - 1, 0, -1):
            line = text[starts[above - 1] : starts[above]].strip()
            if line.startswith("///") and not line.startswith("////"):
                lines.append(line.removeprefix("///").removeprefix(" "))
            elif line or lines:
                break
        return "\n".join(reversed(lines))


def _trees(tree: ParseTree) -> list[ParseTree]:
    return [child for child in tree.children if isinstance(child, Tree)]


def _listed(tree: Any) -> list[ParseTree]:
    """Return the elements of a left-recursive list, which is None where it is empty."""
    elements: list[ParseTree] = []
    while tree is not None:
        elements.append(tree.children[-1])
        tree = tree.children[0]
    elements.reverse()
    return elements


def _optional_text(token: Token | None) -> str | None:
    return None if token is None else str(token)
