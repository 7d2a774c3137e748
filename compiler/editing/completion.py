"""Completions at a cursor: names, types, arguments, units, words of the language."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice

from lark import Token

from bgc.building.build import driver_names
from bgc.diagnostics.catalogue.names import import_place
from bgc.diagnostics.diagnostic import BgError, Edit
from bgc.diagnostics.source import Source
from bgc.editing.file_analysis import Analysis
from bgc.editing.occurrences import Region, members_at
from bgc.editing.symbols import Kind, Members, Symbol, declared_symbol, is_slot
from bgc.grammar import syntax
from bgc.grammar.language_words import TABLE
from bgc.grammar.parse import Reading, parse_setting, read_so_far
from bgc.language.elements import ELEMENTS
from bgc.language.scene_tables import DRIVER_OPTIONS
from bgc.language.shape_table import COLOURS, SHAPES
from bgc.language.solver import SOLVER_OPTIONS
from bgc.record_class import dataclass
from bgc.reference import function_entries, library_entries
from bgc.reference.entry import first_sentence
from bgc.resolution.library import library_modules
from bgc.resolution.modules import ancestors
from bgc.values.interpolation import OPTIONS as INTERPOLATION
from bgc.values.units import PREFIXES, unit_table

_PREFIX = re.compile(r"[A-Za-z_]\w*\Z")
_IN_NUMBER = re.compile(
    r"(?<![\w.])(?:\d+(?:\.\d+)?|\.\d+)(?:[eE][+-]?\d+)? (?P<unit>[A-Za-z_][\w*/^]*)?\Z"
)
_HIDDEN = re.compile(r'//[^\n]*|/\*(?:.*?\*/|.*\Z)|"[^"\n]*(?:"|\Z|(?=\n))', re.DOTALL)
_PATH = re.compile(
    r"[A-Za-z_]\w*(?:\s*\[[^\[\]{};]*\])?(?:\s*\.\s*[A-Za-z_]\w*(?:\s*\[[^\[\]{};]*\])?)*\s*\.\s*\Z"
)
_IMPORTED = re.compile(r"\bimport\s+(?P<path>[\w.]*)\Z")
_IMPORTED_FILE = re.compile(r'\bimport\s+"[^"\n]*\Z')

_VALUES = {"CONST", "PARAM", "LET", "SIGNAL", "INPUT", "OUTPUT", "STATE", "UNKNOWN"}
_NAMES_SOMETHING_NEW = _VALUES | {
    "MODEL", "INTERFACE", "DOMAIN", "FUNCTION", "SCENE", "PORT", "FOR", "AS", "DEVICE", "EFFORT",
    "FLOW",
}  # fmt: skip
_UNIT_WORDS = ("k", "M", "m", "u")
_MOST_COMPLETIONS = 400  # completions of one kind


@dataclass(frozen=True, slots=True)
class Completion:
    """A text for the cursor. `kind` is a `Kind`, `word`, `unit`, `file` or `solver`.

    `also` is a further edit that it needs: the import of a library module.
    """

    text: str
    kind: Kind | str
    detail: str = ""
    doc: str = ""
    also: Edit | None = None


def complete(
    analysis: Analysis, offset: int, solvers: Mapping[str, str] | None = None
) -> tuple[Completion, ...]:
    """Return what may stand at a cursor, whatever of it is written already.

    `solvers` are the integration methods with their purposes, which the runtime knows.
    """
    text = analysis.document.source.text[:offset]
    hidden = next((f for f in _HIDDEN.finditer(text) if f.end() == offset), None)
    if hidden is not None and not hidden.group().endswith("*/"):
        whole_text = hidden.group().startswith('"') and hidden.group()[1:].endswith('"')
        if not whole_text:
            return tuple(_files(analysis)) if _IMPORTED_FILE.search(text) else _colours(text)
    if found := _IMPORTED.search(text):
        return tuple(_modules(found["path"]))
    written = _PREFIX.search(text)
    before = text[: written.start()] if written else text
    source = Source(analysis.document.source.name, before)
    number = _IN_NUMBER.search(text)
    if number:
        source = Source(source.name, text[: number.end() - len(number["unit"] or "") - 1])
    reading = read_so_far(source, "" if number else "x")
    if number:
        return (*_units(), *_words(reading))
    region = analysis.region(analysis.declaration_at(max(offset - 1, 0)))
    if _PATH.search(before):
        return tuple(_inside(before, region, analysis))
    position = _Position(analysis, reading, region, solvers or {})
    return tuple({each.text: each for each in position.completions()}.values())


class _Position:
    """A cursor: the tokens of its statement, and what the parser accepts there."""

    def __init__(
        self,
        analysis: Analysis,
        reading: Reading,
        region: Region,
        solvers: Mapping[str, str],
    ) -> None:
        self.analysis = analysis
        self.reading = reading
        self.region = region
        self.solvers = solvers
        self.statement = list(_statement(reading.tokens))
        self.types = [token.type for token in self.statement]
        self.first = self.types[0] if self.types else ""
        self.last = self.types[-1] if self.types else ""

    def completions(self) -> Iterator[Completion]:
        if "UNIT" in self.reading.accepted and self.last in {"COLON", "IN"}:
            yield from _units()
            if "NAME" not in self.reading.accepted:
                return
        yield from _words(self.reading)
        if "NAME" in self.reading.accepted:
            yield from self._names()

    def _names(self) -> Iterator[Completion]:
        module = self.analysis.module
        call = _open_call(self.statement)
        match self.first, self.last:
            case ("SOLVER", "SOLVER"):
                for name, purpose in self.solvers.items():
                    yield Completion(name, "solver", purpose)
            case ("SHAPE", "SHAPE"):
                for name, kind in SHAPES.items():
                    yield Completion(name, Kind.OPTION, kind.form(name), kind.doc)
            case ("MODEL", "IS"):
                yield from self._types(interfaces=True, elements=False)
            case (_, "OF"):
                yield from self._types(interfaces=False, elements=False)
            case ("SCENE", "IS"):
                for name in module.seen_scenes:
                    yield Completion(name, Kind.SCENE)
            case ("DEVICE", "EQUAL"):
                for name in driver_names():
                    yield Completion(name, Kind.OPTION, "driver")
            case ("PORT", "COLON"):
                yield from self._domains()
            case ("USE", "EQUAL"):
                yield from self._fitting()
            case (_, "COLON") if self.first not in _VALUES | {"EFFORT", "FLOW"}:
                yield from self._types(interfaces=True, elements=True)
            case (_, "EQUAL") if "COLON" in self.types and self.first not in _VALUES and not call:
                yield from self._types(interfaces=False, elements=False)
            case _ if self.last in _NAMES_SOMETHING_NEW:
                return
            case _:
                if call and self.last in {"LPAR", "COMMA"}:
                    yield from self._arguments(call)
                yield from self._values(call)

    def _values(self, call: str) -> Iterator[Completion]:
        """Names and functions of an expression or path."""
        starts, in_chain = not self.statement, "ARROW" in self.types
        for name, symbol in self.region.names.items():
            if (
                symbol.kind in {Kind.PART, Kind.PORT}
                or not (starts or in_chain)
                or (starts and _is_open(symbol))
            ):
                yield _named(name, symbol)
        if (
            starts
            or in_chain
            or self.reading.block == "file"
            or self.first in {"USE", "SET", "KEEP"}
        ):
            return
        for name, summary in function_entries.GROUP.summaries().items():
            yield Completion(name, Kind.BUILTIN, summary)
        for name, declared in self.analysis.module.functions.items():
            yield _named(name, declared_symbol(declared))  # type: ignore[arg-type]
        slot = self.analysis.table.arguments(call, self.analysis.module) if call else {}
        if self.last == "EQUAL" and len(self.types) > 1 and slot:
            target = slot.get(str(self.statement[-2]))
            if target is not None and is_slot(target):
                yield from self._types(interfaces=False, elements=False)

    def _arguments(self, call: str) -> Iterator[Completion]:
        if self.first == "SOLVER":
            for name, option in SOLVER_OPTIONS.items():
                yield Completion(name, Kind.OPTION, f"default {option.default}", option.doc)
        elif self.first == "DEVICE":
            for name in DRIVER_OPTIONS.get(call, {}):
                yield Completion(name, Kind.OPTION, call)
        elif call == "interpolate":
            for name in INTERPOLATION:
                yield Completion(name, Kind.OPTION, "interpolate")
        elif call in SHAPES and self.first == "SHAPE":
            for argument in SHAPES[call].arguments:
                yield Completion(argument.name, Kind.OPTION, argument.takes.value)
        elif call in ELEMENTS:
            for each in ELEMENTS[call].arguments:
                yield Completion(each.name, Kind.OPTION, each.role.value, each.doc)
        else:
            for name, symbol in self.analysis.table.arguments(call, self.analysis.module).items():
                yield _named(name, symbol)

    def _types(self, *, interfaces: bool, elements: bool) -> Iterator[Completion]:
        module = self.analysis.module
        if elements:
            for name, kind in ELEMENTS.items():
                yield Completion(name, Kind.ELEMENT, kind.title, kind.doc)
        for name, declared in module.models.items():
            if interfaces or not declared.syntax.interface:
                yield _named(name, declared_symbol(declared))  # type: ignore[arg-type]
        kinds = {"model", "interface"} if interfaces else {"model"}
        yield from self._library(kinds, module.models)

    def _domains(self) -> Iterator[Completion]:
        module = self.analysis.module
        for name, declared in module.domains.items():
            yield _named(name, declared_symbol(declared))  # type: ignore[arg-type]
        yield from self._library({"domain"}, module.domains)

    def _library(self, kinds: set[str], seen: Mapping[str, object]) -> Iterator[Completion]:
        """Declarations of library modules that the file does not import yet."""
        place = import_place(self.analysis.document.source)
        for found in library_entries.declarations():
            if found.kind in kinds and found.name not in seen:
                edit = Edit(place, f"import {found.module};\n")
                kind = {"model": Kind.MODEL, "interface": Kind.INTERFACE}.get(found.kind)
                doc = first_sentence(found.doc)
                yield Completion(found.name, kind or Kind.DOMAIN, found.module, doc, edit)

    def _fitting(self) -> Iterator[Completion]:
        """The models that fit the slot that a `use` names; all models where it is not known."""
        path = _path_of(self.statement[1:-1])
        symbol = members = None
        if path is not None:
            base = path.base if isinstance(path, syntax.Member) else None
            members = members_at(base, self.region, self.analysis.table) if base else None
            name = path.name if isinstance(path, syntax.Name | syntax.Member) else ""
            symbol = (members or self.region.names).get(name)
        node = symbol.node if symbol is not None else None
        models = self.analysis.module.models
        if isinstance(node, syntax.Part) and node.type.name in models:
            wanted = models[node.type.name].syntax
            for name, declared in models.items():
                if not declared.syntax.interface and any(
                    a.syntax is wanted for a in ancestors(declared)
                ):
                    yield _named(name, declared_symbol(declared))  # type: ignore[arg-type]
        else:
            yield from self._types(interfaces=False, elements=False)


def _is_open(symbol: Symbol) -> bool:
    """Return whether a statement may give a value: an output or signal declared without one."""
    node = symbol.node
    return (
        isinstance(node, syntax.Value) and node.kind in {"output", "signal"} and node.value is None
    )


def _statement(tokens: Sequence[Token]) -> Iterator[Token]:
    """The tokens behind the last `;`, `{` or `}`."""
    start = 0
    for at, token in enumerate(tokens):
        if token.type in {"SEMICOLON", "LBRACE", "RBRACE"}:
            start = at + 1
    yield from tokens[start:]


def _open_call(statement: Sequence[Token]) -> str:
    """The name before the innermost bracket `(` that is open; empty where there is none."""
    depth = 0
    for at in range(len(statement) - 1, 0, -1):
        kind = statement[at].type
        if kind in {"RPAR", "RSQB"}:
            depth += 1
        elif kind in {"LPAR", "LSQB"}:
            if depth == 0:
                return _called(statement[:at]) if kind == "LPAR" else ""
            depth -= 1
    return ""


def _called(before: Sequence[Token]) -> str:
    """The name of a type before its arguments, behind its dimensions: `Lock[5](`."""
    at = len(before) - 1
    if at >= 0 and before[at].type == "RSQB":
        while at >= 0 and before[at].type != "LSQB":
            at -= 1
        at -= 1
    return str(before[at]) if at >= 0 and before[at].type == "NAME" else ""


def _path_of(tokens: Iterable[Token]) -> syntax.Expr | None:
    text = "".join(str(token) for token in tokens)
    return _parsed_path(text)


def _parsed_path(text: str) -> syntax.Expr | None:
    """Parse a path by itself; None if it is none."""
    try:
        return parse_setting(Source("<path>", f"{text} = 0")).target
    except BgError:
        return None


def _inside(before: str, region: Region, analysis: Analysis) -> Iterator[Completion]:
    """The members of the path before a dot."""
    found = _PATH.search(before)
    assert found is not None
    path = _parsed_path(found.group().rstrip().removesuffix("."))
    if path is None:
        return
    members: Members = members_at(path, region, analysis.table)
    for name, symbol in members.items():
        yield _named(name, symbol)


def _named(name: str, symbol: Symbol) -> Completion:
    return Completion(name, symbol.kind, _detail(symbol), first_sentence(symbol.doc))


def _detail(symbol: Symbol) -> str:
    match symbol.node:
        case syntax.Value(kind=kind, unit=unit):
            return f"{kind} : {unit}" if unit else kind
        case syntax.Part(type=use):
            return use.name
        case syntax.Port(domain=domain):
            return f"port : {domain}" if domain else "port"
        case syntax.DomainVariable(kind=kind, unit=unit):
            return f"{kind} : {unit}" if unit else kind
        case _:
            return symbol.kind.value


def _words(reading: Reading) -> Iterator[Completion]:
    """The words of the language that the parser accepts."""
    for kind in sorted(reading.accepted):
        word = TABLE.get(kind.lower())
        if word is not None:
            yield Completion(word.word, "word", word.form.partition(" is ")[2], word.summary)


def _units() -> Iterator[Completion]:
    for word, takes_prefix in unit_table().items():
        yield Completion(word, "unit")
        for prefix in _UNIT_WORDS if takes_prefix else ():
            if prefix in PREFIXES:
                yield Completion(f"{prefix}{word}", "unit")


def _modules(path: str) -> Iterator[Completion]:
    """Library modules; behind a dot the rest of their names."""
    head = path.rpartition(".")[0]
    start = len(head) + 1 if head else 0
    summaries = library_entries.GROUP.summaries()
    for module in library_modules():
        if module.startswith(f"{head}." if head else ""):
            yield Completion(module[start:], Kind.MODULE, summaries[module])


def _files(analysis: Analysis) -> Iterator[Completion]:
    """The other files of the folder."""
    folder = analysis.document.path.parent
    try:
        found = sorted(islice(folder.glob("*.bg"), _MOST_COMPLETIONS))
    except OSError:
        return
    for path in found:
        if path != analysis.document.path:
            yield Completion(path.name, "file")


def _colours(text: str) -> tuple[Completion, ...]:
    if not re.search(r'\bcolour\s+"[^"\n]*\Z', text):
        return ()
    return tuple(Completion(name, Kind.OPTION, code) for name, code in COLOURS.items())
