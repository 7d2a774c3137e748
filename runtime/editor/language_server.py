"""The language server of `bgc lsp`: requests of the protocol as calls of the session."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import version
from pathlib import Path
from threading import Event
from typing import Any
from urllib.parse import urlsplit

from lsprotocol import types
from pygls import uris
from pygls.exceptions import JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer

from bgc.diagnostics.diagnostic import BgError
from bgc.editing.completion import complete
from bgc.editing.hover import hover
from bgc.editing.lines import Encoding, Lines
from bgc.editing.outline import outline
from bgc.editing.rename import references, rename, renameable
from bgc.grammar.format import format_source
from bgc.runtime.editor import lsp_values
from bgc.runtime.editor.graph_preview import Asked, preview
from bgc.runtime.editor.session import Cancelled, Checked, Session

_QUIET = 0.3  # s without an edit, after which a file is compiled


class Server(LanguageServer):
    """The server with its session; a file is compiled in the background once edits pause."""

    def __init__(self) -> None:
        super().__init__("bgc", version("bgc-lang"))
        self.session = Session()
        self._paths: dict[str, Path] = {}
        self._waiting: dict[Path, asyncio.TimerHandle] = {}
        self._cancel: dict[Path, Event] = {}
        self.background = ThreadPoolExecutor(1, "bgc-check")

    # --- texts and places ---------------------------------------------------------------

    def path_of(self, uri: str) -> Path:
        """Return the path of a document; one that is not saved gets a path in the workspace."""
        if uri not in self._paths:
            if urlsplit(uri).scheme == "file":
                path = Path(uris.to_fs_path(uri) or "")
            else:
                folder = self.session.folders[0] if self.session.folders else Path.cwd()
                name = "".join(c if c.isalnum() or c in "-_" else "_" for c in uri)
                path = folder / f"{name}.bg"
            self._paths[uri] = path.resolve()
        return self._paths[uri]

    def uri_of(self, name: str) -> str:
        """Return the document of a path: as the editor named it, if it did."""
        path = Path(name)
        for uri, known in self._paths.items():
            if known == path:
                return uri
        return uris.from_fs_path(name) or name

    @property
    def encoding(self) -> Encoding:
        """The unit in which the editor counts columns."""
        match self.workspace.position_encoding:
            case types.PositionEncodingKind.Utf8:
                return "utf-8"
            case types.PositionEncodingKind.Utf32:
                return "utf-32"
            case _:
                return "utf-16"

    def lines(self, text: str) -> Lines:
        """Return the lines of a text, with columns in the editor's unit."""
        return Lines(text, self.encoding)

    def places(self) -> lsp_values.Places:
        """Return the conversion of spans to locations of the protocol."""
        return lsp_values.Places(self.uri_of, self.lines)

    def cursor(self, uri: str, position: types.Position) -> tuple[Path, int]:
        """Return the path and the offset of a position; BgError if the file cannot be read."""
        path = self.path_of(uri)
        text = self.session.documents.document(path).source.text
        return path, self.lines(text).offset((position.line, position.character))

    # --- the compiler in the background -------------------------------------------------

    def changed(self, uri: str) -> None:
        """Take the text of a document, publish syntax and names, and plan a check."""
        path = self.path_of(uri)
        self.session.change(path, self.workspace.get_text_document(uri).source)
        self._publish(uri)
        for importer, known in list(self._paths.items()):
            if known != path and known in self.session.documents.open_paths:
                self._publish(importer)
                self._plan(importer)
        self._plan(uri)

    def closed(self, uri: str) -> None:
        """Forget a document."""
        path = self.path_of(uri)
        self._stop(path)
        self.session.close(path)
        self._paths.pop(uri, None)
        self.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, []))

    def _publish(self, uri: str) -> None:
        found = self.session.diagnostics(self.path_of(uri))
        places = self.places()
        shown = [places.diagnostic(each) for each in found]
        self.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, shown))

    def _stop(self, path: Path) -> None:
        """Cancel the check of a file that waits or runs."""
        if (timer := self._waiting.pop(path, None)) is not None:
            timer.cancel()
        if (event := self._cancel.pop(path, None)) is not None:
            event.set()

    def _plan(self, uri: str) -> None:
        path = self.path_of(uri)
        self._stop(path)
        loop = asyncio.get_running_loop()
        self._waiting[path] = loop.call_later(_QUIET, self._start, uri)

    def _start(self, uri: str) -> None:
        path = self.path_of(uri)
        self._waiting.pop(path, None)
        try:
            check = self.session.prepare(path)
        except BgError:
            return  # published already
        event = self._cancel[path] = Event()
        job = asyncio.get_running_loop().run_in_executor(self.background, check, event)
        job.add_done_callback(lambda done: self._done(uri, done))

    def _done(self, uri: str, done: asyncio.Future[Checked]) -> None:
        if done.cancelled() or isinstance(done.exception(), Cancelled):
            return
        if uri in self._paths and self.session.take(done.result()):
            self._publish(uri)
            capabilities = self.client_capabilities.workspace
            hints = capabilities.inlay_hint if capabilities is not None else None
            if hints is not None and hints.refresh_support:
                self.workspace_inlay_hint_refresh(None)


def make_server(solvers: dict[str, str]) -> Server:
    """Make a server; `solvers` are the integration methods with their purposes."""
    server = Server()
    _add_texts(server)
    _add_questions(server, solvers)
    _add_edits(server)
    _add_graph(server)
    return server


def _add_texts(server: Server) -> None:
    @server.feature(types.INITIALIZED)
    def initialized(params: types.InitializedParams) -> None:
        folders = server.workspace.folders.values()
        paths = [uris.to_fs_path(folder.uri) for folder in folders]
        if not paths and server.workspace.root_path:
            paths = [server.workspace.root_path]
        server.session.folders = [Path(path).resolve() for path in paths if path]

    @server.feature(types.TEXT_DOCUMENT_DID_OPEN)
    def opened(params: types.DidOpenTextDocumentParams) -> None:
        server.changed(params.text_document.uri)

    @server.feature(types.TEXT_DOCUMENT_DID_CHANGE)
    def changed(params: types.DidChangeTextDocumentParams) -> None:
        server.changed(params.text_document.uri)

    @server.feature(types.TEXT_DOCUMENT_DID_SAVE)
    def saved(params: types.DidSaveTextDocumentParams) -> None:
        server.session.forget_files()
        server.changed(params.text_document.uri)

    @server.feature(types.TEXT_DOCUMENT_DID_CLOSE)
    def closed(params: types.DidCloseTextDocumentParams) -> None:
        server.closed(params.text_document.uri)

    @server.feature(types.WORKSPACE_DID_CHANGE_WATCHED_FILES)
    def watched(params: types.DidChangeWatchedFilesParams) -> None:
        server.session.forget_files()


def _add_questions(server: Server, solvers: dict[str, str]) -> None:
    session = server.session

    @server.feature(types.TEXT_DOCUMENT_HOVER)
    def hovered(params: types.HoverParams) -> types.Hover | None:
        path, offset = server.cursor(params.text_document.uri, params.position)
        found = hover(session.analysis(path), offset, session.facts(path))
        if found is None:
            return None
        span, text = found
        content = types.MarkupContent(types.MarkupKind.Markdown, text)
        return types.Hover(content, server.places().range(span))

    @server.feature(
        types.TEXT_DOCUMENT_COMPLETION, types.CompletionOptions(trigger_characters=[".", " ", '"'])
    )
    def completed(params: types.CompletionParams) -> types.CompletionList:
        path, offset = server.cursor(params.text_document.uri, params.position)
        analysis = session.analysis(path)
        character = params.context.trigger_character if params.context else None
        before = analysis.document.source.text[:offset].rstrip(" ")[-1:]
        if character == " " and (not before or (before not in ":=,>" and not before.isalnum())):
            return types.CompletionList(False, [])
        found = complete(analysis, offset, solvers)
        places = server.places()
        source = analysis.document.source
        items = [places.completion(each, source) for each in found]
        return types.CompletionList(False, items)

    @server.feature(types.TEXT_DOCUMENT_DEFINITION)
    def defined(params: types.DefinitionParams) -> types.Location | None:
        path, offset = server.cursor(params.text_document.uri, params.position)
        span = session.analysis(path).definition(offset)
        return None if span is None else server.places().location(span)

    @server.feature(types.TEXT_DOCUMENT_REFERENCES)
    def referred(params: types.ReferenceParams) -> list[types.Location]:
        path, offset = server.cursor(params.text_document.uri, params.position)
        analysis = session.analysis(path)
        found = analysis.at(offset)
        if found is None or found.symbol is None:
            return []
        symbol, places = found.symbol, server.places()
        spans = references(symbol, analysis, session.roots(), session.documents)
        own = (symbol.span.source.name, symbol.span.start) if symbol.span else None
        return [
            places.location(span)
            for span in spans
            if params.context.include_declaration or (span.source.name, span.start) != own
        ]

    @server.feature(types.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
    def outlined(params: types.DocumentSymbolParams) -> list[types.DocumentSymbol]:
        path = server.path_of(params.text_document.uri)
        places = server.places()
        return [places.symbol(h) for h in outline(session.documents.document(path).file)]

    @server.feature(types.TEXT_DOCUMENT_INLAY_HINT)
    def hinted(params: types.InlayHintParams) -> list[types.InlayHint]:
        path = server.path_of(params.text_document.uri)
        lines = server.lines(session.documents.document(path).source.text)
        first = lines.offset((params.range.start.line, params.range.start.character))
        last = lines.offset((params.range.end.line, params.range.end.character))
        shown = (h for h in session.hints(path) if first <= h.offset <= last)
        return [lsp_values.inlay_hint(each, lines) for each in shown]

    @server.feature(types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL, lsp_values.LEGEND)
    def coloured(params: types.SemanticTokensParams) -> types.SemanticTokens:
        analysis = session.analysis(server.path_of(params.text_document.uri))
        lines = server.lines(analysis.document.source.text)
        return lsp_values.semantic_tokens(analysis.occurrences, lines)


def _add_edits(server: Server) -> None:
    session = server.session

    @server.feature(types.TEXT_DOCUMENT_FORMATTING)
    def formatted(params: types.DocumentFormattingParams) -> list[types.TextEdit] | None:
        source = session.documents.document(server.path_of(params.text_document.uri)).source
        try:
            text = format_source(source)
        except BgError:
            return None  # the diagnostics name the syntax errors
        if text == source.text:
            return []
        end = server.lines(source.text).end()
        whole = types.Range(types.Position(0, 0), types.Position(*end))
        return [types.TextEdit(whole, text)]

    @server.feature(types.TEXT_DOCUMENT_PREPARE_RENAME)
    def prepared(params: types.PrepareRenameParams) -> types.PrepareRenamePlaceholder:
        path, offset = server.cursor(params.text_document.uri, params.position)
        try:
            found = renameable(session.analysis(path), offset, session.may_change)
        except BgError as problem:
            raise _refused(problem) from None
        return types.PrepareRenamePlaceholder(server.places().range(found.span), found.span.text)

    @server.feature(types.TEXT_DOCUMENT_RENAME, types.RenameOptions(prepare_provider=True))
    def renamed(params: types.RenameParams) -> types.WorkspaceEdit:
        path, offset = server.cursor(params.text_document.uri, params.position)
        try:
            edits = rename(
                session.analysis(path),
                offset,
                params.new_name,
                session.roots(),
                session.documents,
                session.may_change,
            )
        except BgError as problem:
            raise _refused(problem) from None
        return server.places().workspace_edit(edits)

    @server.feature(
        types.TEXT_DOCUMENT_CODE_ACTION,
        types.CodeActionOptions(code_action_kinds=[types.CodeActionKind.QuickFix]),
    )
    def corrected(params: types.CodeActionParams) -> list[types.CodeAction]:
        path = server.path_of(params.text_document.uri)
        places = server.places()
        found: list[types.CodeAction] = []
        for diagnostic in session.diagnostics(path):
            shown = places.diagnostic(diagnostic)
            if diagnostic.edits and lsp_values.overlap(shown.range, params.range):
                found += places.actions(diagnostic, shown)
        return found


def _add_graph(server: Server) -> None:
    @server.feature("bgc/graph")
    async def drawn(params: Any) -> dict[str, Any]:
        """Draw a scene of the document `uri`; `scene` and `depth` are optional (`preview.py`)."""
        uri = getattr(params, "uri", None)
        if not isinstance(uri, str):
            raise JsonRpcInvalidParams(message="`uri` is missing")
        path = server.path_of(uri)
        try:
            analysis = server.session.analysis(path)
        except BgError as problem:
            raise _refused(problem) from None
        loop, asked = asyncio.get_running_loop(), Asked.read(params)
        found = await loop.run_in_executor(server.background, preview, path, analysis, asked)
        return found.content()


def _refused(problem: BgError) -> Any:
    """A refusal that the editor shows: message and way out of the first diagnostic."""
    first = problem.diagnostics[0]
    return JsonRpcInvalidParams(message=f"{first.code}: {first.message} ({first.help})")
