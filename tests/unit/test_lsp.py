"""The language server: its session called directly, and one whole session over its pipes."""

import asyncio
import sys
from pathlib import Path
from threading import Event
from types import SimpleNamespace

import pytest
import pytest_lsp
from lsprotocol import types

from bgc.diagnostics.diagnostic import BgError
from bgc.editing.completion import complete
from bgc.editing.hover import hover
from bgc.runtime.editor.graph_preview import Asked, preview
from bgc.runtime.editor.session import Cancelled, Session

README = Path(__file__).parents[2] / "README.md"
MODEL = README.read_text("utf-8").split("```bg\n")[1].split("```")[0]


def checked(session: Session, path: Path) -> None:
    assert session.take(session.check(path, Event()))


@pytest.fixture
def session(tmp_path):
    found = Session()
    found.folders = [tmp_path]
    return found


def test_the_compiler_reports_after_syntax_and_names(session, tmp_path):
    path = tmp_path / "a.bg"
    session.change(path, MODEL.replace("loop -> coil", "loop -> coil, loop -> coil"))
    assert {d.code for d in session.diagnostics(path)} == {"BG125"}
    session.change(path, MODEL.replace("R = 2 ohm", "R = 2 kg"))
    assert not session.diagnostics(path)
    checked(session, path)
    (found,) = session.diagnostics(path)
    assert found.code == "BG423" or found.span is not None
    # The diagnostic moves with its line, and goes once what it names is edited.
    before = found.span.start
    session.change(path, "// comment\n" + MODEL.replace("R = 2 ohm", "R = 2 kg"))
    (found,) = session.diagnostics(path)
    assert found.span.start == before + len("// comment\n")
    session.change(path, MODEL)
    checked(session, path)
    assert not session.diagnostics(path)


def test_a_check_ends_when_it_is_cancelled_and_an_old_one_is_dropped(session, tmp_path):
    path = tmp_path / "a.bg"
    session.change(path, MODEL)
    cancelled = Event()
    cancelled.set()
    with pytest.raises(Cancelled):
        session.check(path, cancelled)
    check = session.prepare(path)
    session.change(path, MODEL + "\n")
    assert not session.take(check(Event()))


def test_an_unsaved_buffer_is_imported(session, tmp_path):
    part, whole = tmp_path / "part.bg", tmp_path / "whole.bg"
    session.change(part, "model Spring { port a; s : C(1); a -> s; }")
    session.change(whole, 'import "part.bg";\nmodel A { s : Spring; j : Se(1); j -> s; }')
    assert not session.diagnostics(whole)
    found = session.analysis(whole).definition(len('import "part.bg";\nmodel A { s : Sp'))
    assert found.source.name == str(part) and found.text == "Spring"
    session.change(part, "model Sprung { port a; s : C(1); a -> s; }")
    (diagnostic,) = session.diagnostics(whole)
    assert diagnostic.code == "BG201" and diagnostic.edits[0].text == "Sprung"
    session.change(part, "model Spring { port a; s : C(1); a - s; }")
    (diagnostic,) = session.diagnostics(whole)
    assert diagnostic.span.text == 'import "part.bg"' and diagnostic.message.startswith("in part")
    session.close(part)
    assert {d.code for d in session.diagnostics(whole)} == {"BG020"}


def test_a_fault_of_the_compiler_is_a_diagnostic(session, tmp_path, monkeypatch):
    def fail(*_, **__):
        raise ZeroDivisionError("of a test")

    monkeypatch.setattr("bgc.runtime.editor.session.check_package", fail)
    path = tmp_path / "a.bg"
    session.change(path, MODEL)
    checked(session, path)
    (found,) = session.diagnostics(path)
    assert found.code == "BG136" and "ZeroDivisionError: of a test" in found.message


def test_the_readme_model_typed_key_by_key(session, tmp_path):
    """Diagnostics, completion and hover at every text that a user has on the way."""
    path = tmp_path / "rlc.bg"
    for end in range(len(MODEL) + 1):
        session.change(path, MODEL[:end])
        for diagnostic in session.diagnostics(path):
            assert diagnostic.span is not None and diagnostic.span.end <= end and diagnostic.help
        analysis = session.analysis(path)
        offered = {each.text for each in complete(analysis, end)}
        word = MODEL[:end].rpartition("\n")[2].split(" ")[-1]
        if word == "capacitor.":
            assert offered == {"e", "f", "q", "power"}
        if end == MODEL.index("observe"):
            assert {"observe", "run"} <= offered
        hover(analysis, end - 1, session.facts(path))
    assert not session.diagnostics(path)
    checked(session, path)
    assert not session.diagnostics(path)
    assert [h.text for h in session.hints(path)] == ["->|", "->|", "|->", "|->"]


# --- over the pipes -----------------------------------------------------------------------


def make_client() -> pytest_lsp.LanguageClient:
    """The client of pytest-lsp, which counts how often it is told to ask for hints again."""
    client = pytest_lsp.make_test_lsp_client()
    client.refreshes = 0

    @client.feature(types.WORKSPACE_INLAY_HINT_REFRESH)
    def refreshed(params: None) -> None:
        client.refreshes += 1

    return client


START = "from bgc.runtime.cli import main; main()"
CONFIG = pytest_lsp.ClientServerConfig([sys.executable, "-c", START, "lsp"], make_client)


@pytest_lsp.fixture(config=CONFIG, params=["neovim", "visual-studio-code"])
async def client(started: pytest_lsp.LanguageClient, request, tmp_path):
    """A session with what an editor declares that it can do."""
    folder = types.WorkspaceFolder(tmp_path.as_uri(), "test")
    editor = pytest_lsp.client_capabilities(request.param)
    answer = await started.initialize_session(
        types.InitializeParams(editor, workspace_folders=[folder])
    )
    started.encoding = answer.capabilities.position_encoding or "utf-16"
    yield
    await started.shutdown_session()
    assert started._server.returncode == 0


# pytest-lsp warns of what the server sends although the editor has not declared that it takes it.
@pytest.mark.filterwarnings("error::pytest_lsp.LspSpecificationWarning")
@pytest.mark.timeout(60)
@pytest.mark.asyncio
async def test_a_session_over_standard_input_and_output(client):
    def column(before: str) -> int:
        units = {"utf-8": 1, "utf-16": 2, "utf-32": 4}[client.encoding]
        mark = len("".encode(client.encoding))  # of the order of bytes
        return (len(before.encode(client.encoding)) - mark) // units

    uri, text = "untitled:Untitled-1", "/// 𝄞 é\n" + MODEL
    client.text_document_did_open(
        types.DidOpenTextDocumentParams(types.TextDocumentItem(uri, "bg", 1, text))
    )
    document = types.TextDocumentIdentifier(uri)
    everything = types.Range(types.Position(0, 0), types.Position(99, 0))
    asked = types.InlayHintParams(document, everything)
    while not (hints := await client.text_document_inlay_hint_async(asked)):
        await asyncio.sleep(0.02)
    assert [hint.label for hint in hints] == ["->|", "->|", "|->", "|->"]
    assert not client.diagnostics[uri]
    workspace = client.capabilities.workspace
    assert client.refreshes == (workspace.inlay_hint is not None)

    # A key: `R = 2 ohm` becomes `R = 2 oh`, in a line behind characters of two UTF-16 units.
    note = "  /* 𝄞𝄞 */ param R = 2 ohm;"
    line = text.splitlines().index("  param R = 2 ohm;")
    version = types.VersionedTextDocumentIdentifier(2, uri)
    whole = types.Range(types.Position(line, 0), types.Position(line, 99))
    change = types.TextDocumentContentChangePartial(whole, note.replace("ohm", "oh"))
    client.text_document_did_change(types.DidChangeTextDocumentParams(version, [change]))
    while not client.diagnostics[uri]:
        await asyncio.sleep(0.01)
    (diagnostic,) = client.diagnostics[uri]
    assert diagnostic.code == "BG301"
    assert diagnostic.range.start.line == line
    assert diagnostic.range.start.character == column(note[: note.index("2 oh")])

    position = types.Position(line, column(note[: note.index("R =")]))
    shown = await client.text_document_hover_async(types.HoverParams(document, position))
    assert "param R" in shown.contents.value
    assert shown.range.start == position
    renamed = await client.text_document_rename_async(
        types.RenameParams(document, position, "resistance")
    )
    assert len(renamed.changes[uri]) == 2 and renamed.changes[uri][0].range.start == position
    with pytest.raises(Exception, match="BG135"):
        await client.text_document_rename_async(types.RenameParams(document, position, "L"))
    found = await client.text_document_references_async(
        types.ReferenceParams(types.ReferenceContext(True), document, position)
    )
    assert len(found) == 2
    symbols = await client.text_document_document_symbol_async(types.DocumentSymbolParams(document))
    assert [symbol.name for symbol in symbols] == ["RLC", "step"]
    colours = await client.text_document_semantic_tokens_full_async(
        types.SemanticTokensParams(document)
    )
    assert len(colours.data) % 5 == 0 and len(colours.data) > 50
    drawn = await client.protocol.send_request_async("bgc/graph", {"uri": uri})
    assert drawn.message.startswith("BG301") and not drawn.svg  # the text has an error
    corrected = types.TextDocumentContentChangePartial(whole, note)
    client.text_document_did_change(
        types.DidChangeTextDocumentParams(
            types.VersionedTextDocumentIdentifier(3, uri), [corrected]
        )
    )
    drawn = await client.protocol.send_request_async("bgc/graph", {"uri": uri})
    assert not drawn.message and drawn.scene == "step" and drawn.scenes == ["step"]
    assert drawn.svg.startswith("<svg") and "coil" in drawn.svg


def test_an_unreadable_file_is_an_error_with_its_reason(session, tmp_path):
    with pytest.raises(BgError, match="BG001"):
        session.analysis(tmp_path / "missing.bg")
    assert session.diagnostics(tmp_path / "missing.bg")[0].code == "BG001"


def test_the_graph_of_a_scene_is_drawn_to_a_depth_or_refused(session, tmp_path):
    path = tmp_path / "a.bg"
    session.change(path, "model A { j : J1; s : Se(1); s -> j; }")
    found = preview(path, session.analysis(path), Asked())
    assert found.message == "the file has no scene"
    inner = (
        "model B { port p; r : R(2); p -> r; } model A { j : J1; s : Se(1); b : B; s -> j -> b; }"
    )
    session.change(path, f"{inner} scene one of A {{ observe s.f; run 1 s; }}"
                         " scene two of A { observe b.r.e; run 1 s; }")  # fmt: skip
    whole = preview(path, session.analysis(path), Asked("two"))
    assert (whole.scene, whole.scenes, whole.depth) == ("two", ("one", "two"), -1)
    closed = preview(path, session.analysis(path), Asked("two", 0))
    assert closed.depth == 0 and closed.depths == 1
    assert whole.svg.count("<g ") > closed.svg.count("<g ")
    other = preview(path, session.analysis(path), Asked("three"))
    assert other.scene == "one"  # a scene that was renamed


def test_a_question_for_a_graph_may_have_wrong_fields():
    assert Asked.read(SimpleNamespace(scene=3, depth=True)) == Asked()
    assert Asked.read(SimpleNamespace(scene="", depth=-1)) == Asked()
    assert Asked.read(SimpleNamespace(scene="s", depth=2)) == Asked("s", 2)
