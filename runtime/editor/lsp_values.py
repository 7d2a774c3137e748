"""Values of bgc as values of the language server protocol."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from lsprotocol import types

from bgc.diagnostics.diagnostic import Diagnostic, Edit, Severity
from bgc.diagnostics.source import Source, Span
from bgc.editing.completion import Completion
from bgc.editing.hints import Hint
from bgc.editing.lines import Lines
from bgc.editing.occurrences import Occurrence
from bgc.editing.outline import Heading
from bgc.editing.symbols import Kind
from bgc.grammar import syntax
from bgc.record_class import dataclass, field

_SEVERITY = {
    Severity.ERROR: types.DiagnosticSeverity.Error,
    Severity.WARNING: types.DiagnosticSeverity.Warning,
    Severity.INFO: types.DiagnosticSeverity.Information,
}
_SYMBOLS = {
    Kind.MODEL: types.SymbolKind.Class,
    Kind.INTERFACE: types.SymbolKind.Interface,
    Kind.DOMAIN: types.SymbolKind.Struct,
    Kind.FUNCTION: types.SymbolKind.Function,
    Kind.SCENE: types.SymbolKind.Event,
    Kind.PORT: types.SymbolKind.Property,
    Kind.PART: types.SymbolKind.Field,
}
_ITEMS: dict[Kind | str, types.CompletionItemKind] = {
    Kind.MODEL: types.CompletionItemKind.Class,
    Kind.INTERFACE: types.CompletionItemKind.Interface,
    Kind.DOMAIN: types.CompletionItemKind.Struct,
    Kind.FUNCTION: types.CompletionItemKind.Function,
    Kind.BUILTIN: types.CompletionItemKind.Function,
    Kind.SCENE: types.CompletionItemKind.Event,
    Kind.MODULE: types.CompletionItemKind.Module,
    Kind.ELEMENT: types.CompletionItemKind.Class,
    Kind.PORT: types.CompletionItemKind.Property,
    Kind.PART: types.CompletionItemKind.Field,
    Kind.OPTION: types.CompletionItemKind.EnumMember,
    "word": types.CompletionItemKind.Keyword,
    "unit": types.CompletionItemKind.Unit,
    "file": types.CompletionItemKind.File,
    "solver": types.CompletionItemKind.EnumMember,
}
_TOKENS = ("class", "interface", "struct", "function", "event", "property", "variable",
           "parameter", "namespace", "enumMember")  # fmt: skip
_TOKEN_OF = {
    Kind.MODEL: "class",
    Kind.ELEMENT: "class",
    Kind.INTERFACE: "interface",
    Kind.DOMAIN: "struct",
    Kind.FUNCTION: "function",
    Kind.BUILTIN: "function",
    Kind.SCENE: "event",
    Kind.PORT: "property",
    Kind.READABLE: "property",
    Kind.QUANTITY: "property",
    Kind.PART: "variable",
    Kind.VALUE: "parameter",
    Kind.DIMENSION: "parameter",
    Kind.ARGUMENT: "parameter",
    Kind.MODULE: "namespace",
    Kind.OPTION: "enumMember",
}
_DECLARATION, _READONLY = 1, 2

LEGEND = types.SemanticTokensLegend(list(_TOKENS), ["declaration", "readonly"])
"""The kinds of names that the editor may colour."""


@dataclass(frozen=True)
class Places:
    """Converts spans: `uri_of` names the document of a source, `lines_of` splits its text."""

    uri_of: Callable[[str], str]
    lines_of: Callable[[str], Lines]
    _lines: dict[str, Lines] = field(default_factory=dict)

    def lines(self, source: Source) -> Lines:
        """Return the lines of a source, split once."""
        if source.name not in self._lines or self._lines[source.name].text != source.text:
            self._lines[source.name] = self.lines_of(source.text)
        return self._lines[source.name]

    def range(self, span: Span) -> types.Range:
        """Return the range of a span."""
        lines = self.lines(span.source)
        start, end = lines.position(span.start), lines.position(span.end)
        return types.Range(types.Position(*start), types.Position(*end))

    def location(self, span: Span) -> types.Location:
        """Return the document and range of a span."""
        return types.Location(self.uri_of(span.source.name), self.range(span))

    def diagnostic(self, each: Diagnostic) -> types.Diagnostic:
        """Return a diagnostic, its way out and note in the message, its labels as related."""
        assert each.span is not None
        parts = [each.message, *([each.note] if each.note else [])]
        parts += [f"help: {each.help}"] if each.help else []
        related = [
            types.DiagnosticRelatedInformation(self.location(label.span), label.text or "here")
            for label in each.labels
        ]
        return types.Diagnostic(
            self.range(each.span),
            "\n".join(parts),
            _SEVERITY[each.severity],
            each.code,
            source="bgc",
            related_information=related or None,
        )

    def text_edit(self, edit: Edit) -> types.TextEdit:
        """Return an edit of one document."""
        return types.TextEdit(self.range(edit.span), edit.text)

    def workspace_edit(self, edits: Iterable[Edit]) -> types.WorkspaceEdit:
        """Return edits by document."""
        changes: dict[str, list[types.TextEdit]] = {}
        for edit in edits:
            uri = self.uri_of(edit.span.source.name)
            changes.setdefault(uri, []).append(self.text_edit(edit))
        return types.WorkspaceEdit({uri: tuple(some) for uri, some in changes.items()})

    def actions(self, each: Diagnostic, shown: types.Diagnostic) -> list[types.CodeAction]:
        """Return the edits of a diagnostic as code actions."""
        return [
            types.CodeAction(
                _title(edit),
                types.CodeActionKind.QuickFix,
                [shown],
                is_preferred=number == 0,
                edit=self.workspace_edit([edit]),
            )
            for number, edit in enumerate(each.edits)
        ]

    def completion(self, each: Completion, source: Source) -> types.CompletionItem:
        """Return a completion with the edit that it needs besides."""
        also = [self.text_edit(each.also)] if each.also is not None else None
        kind = _ITEMS.get(each.kind, types.CompletionItemKind.Variable)
        # What the file sees stands before what would have to be imported.
        order = "2" if also else "1" if kind is types.CompletionItemKind.Keyword else "0"
        return types.CompletionItem(
            each.text,
            kind=kind,
            detail=each.detail or None,
            documentation=each.doc or None,
            sort_text=f"{order}{each.text}",
            additional_text_edits=also,
        )

    def symbol(self, heading: Heading) -> types.DocumentSymbol:
        """Return an entry of the outline."""
        kind = _SYMBOLS.get(heading.kind, types.SymbolKind.Variable)
        return types.DocumentSymbol(
            heading.name,
            kind,
            self.range(heading.span),
            self.range(heading.name_span),
            heading.detail or None,
            children=[self.symbol(inner) for inner in heading.inner],
        )


def _title(edit: Edit) -> str:
    old, new = edit.span.text, edit.text.strip()
    if not edit.text:
        return f"remove `{old}`"
    if new.startswith("import "):
        return f"add `{new}`"
    return f"replace `{old}` by `{new}`" if old else f"insert `{new}`"


def overlap(one: types.Range, other: types.Range) -> bool:
    """Return whether two ranges have a place in common, their ends included."""
    first = (one.start.line, one.start.character), (one.end.line, one.end.character)
    second = (other.start.line, other.start.character), (other.end.line, other.end.character)
    return first[0] <= second[1] and second[0] <= first[1]


def inlay_hint(hint: Hint, lines: Lines) -> types.InlayHint:
    """Return a hint within the text."""
    return types.InlayHint(
        types.Position(*lines.position(hint.offset)),
        hint.text,
        types.InlayHintKind.Type,
        tooltip=types.MarkupContent(types.MarkupKind.Markdown, hint.explanation),
        padding_left=not hint.before,
        padding_right=hint.before,
    )


def semantic_tokens(found: Sequence[Occurrence], lines: Lines) -> types.SemanticTokens:
    """Return the kinds of all names of a file, as differences from name to name."""
    data: list[int] = []
    line, column = 0, 0
    for occurrence in found:
        symbol = occurrence.symbol
        kind = None if symbol is None else _TOKEN_OF.get(symbol.kind, "variable")
        start = lines.position(occurrence.span.start)
        end = lines.position(occurrence.span.end)
        if symbol is None or kind is None or start[0] != end[0]:
            continue
        place = symbol.span
        declares = place is not None and (
            (place.source.name, place.start) == (occurrence.span.source.name, occurrence.span.start)
        )
        node = symbol.node
        fixed = isinstance(node, syntax.Value) and node.kind in {"const", "param"}
        modifiers = _DECLARATION * declares + _READONLY * fixed
        same = start[0] == line
        data += [
            start[0] - line,
            start[1] - (column if same else 0),
            end[1] - start[1],
            _TOKENS.index(kind),
            modifiers,
        ]
        line, column = start
    return types.SemanticTokens(data)
