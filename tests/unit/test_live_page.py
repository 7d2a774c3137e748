"""Pages that run their model: in Chromium from a file, without a network, and their data."""

import gzip
import json
import re
import sys
import time

import numpy as np
import pytest
from chromium import CHROMIUM, View
from click.testing import CliRunner
from model_files import model_text
from refusals import refusal

import bgc
from bgc.building.cache import open_cache
from bgc.diagnostics.diagnostic import BgError
from bgc.options import Options
from bgc.resolution.library import library_folder
from bgc.runtime.cli.app import application
from bgc.runtime.running.failures import explain
from bgc.runtime.running.run import with_capped_step
from bgc.runtime.running.simulate import method_of
from bgc.runtime.running.structures import Status
from bgc.runtime.web import gallery, page_export
from bgc.runtime.web import module as modules
from bgc.runtime.web.content import run_settings
from bgc.runtime.web.faults import fault_messages
from bgc.runtime.web.page_export import LivePage, live_page

MODEL = model_text("live_page")
TRACE = "time,x,y,z\n0,0,0,0\n1,0,0,0\n2,0,0,0.05\n3,0,0,-0.03\n"

GRIP = """(() => { const g = bgcView.devices.grips[0], b = g.stage.canvas.getBoundingClientRect();
  const p = g.onScreen(g.knob.position); return [b.left + p.x, b.top + p.y]; })()"""
STICK = """(down) => { navigator.getGamepads = () => [{ connected: true,
  axes: [0, 0, 0, down], buttons: new Array(8).fill({ pressed: false, value: 0 }) }]; }"""


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("live") / "lift.bg"
    path.write_text(MODEL, "utf-8")
    (path.parent / "grip.csv").write_text(TRACE, "utf-8")
    return path


@pytest.fixture(scope="module")
def model(file):
    return bgc.compile(file, scene="lift", shapes=True)


@pytest.fixture(scope="module")
def live(file):
    """The page of the scene, written by the command."""
    arguments = ["build", str(file), "--scene", "lift", "--target", "html", "-o", str(file.parent)]
    done = CliRunner().invoke(application, arguments)
    assert done.exit_code == 0, done.output
    path = file.parent / "lift.lift.html"
    assert done.output.strip() == str(path)
    return path


# --- the page in a browser --------------------------------------------------------------------


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium")
def test_a_file_runs_its_model_without_a_network(browser, live, model):
    view = View(browser, f"{live.as_uri()}?quality=low", offline=True, has_touch=True)
    view.until("bgcView.store?.count === 1 && bgcView.player.ready")
    # A run in the page is that of the shared object, but for the last bits of sums and functions.
    times = [0.05 * k for k in range(101)]
    done = view.ask(f"bgcView.source.simulate({times})")
    native = np.full((101, model.row_width), np.nan)
    with model.started(with_capped_step(method_of(model)[0], np.array(times), True), False) as run:
        assert run.run(np.array(times), native) == (Status.OK, 101)
    rows = np.array(done["rows"])
    assert np.ptp(native[:, 0]) > 0.3  # the recorded motion moves it, from its start at rest
    assert abs(native[0, 0] - np.arcsin(0.3)) < 1e-9
    np.testing.assert_allclose(rows, native, rtol=0, atol=1e-11)
    # Played, it does the same, in a worker.
    assert any(url.startswith("blob:") for url in view.requests)
    view.ask("bgcView.setSpeed(20)")
    view.page.keyboard.press("Space")
    view.until("bgcView.player.ended")
    assert view.ask("bgcView.store.last") == pytest.approx(5)
    view.until(f"Math.abs(bgcView.row[0] - {native[-1, 0]}) < 1e-6")
    # The mouse takes the device from the recorded motion; the run starts by itself.
    view.ask("{bgcView.setSpeed(1); bgcView.source.send('reset')}")
    view.until("bgcView.player.epoch === 1 && bgcView.store.count === 1")
    frames = view.ask("bgcView.frames")
    view.until(f"bgcView.frames > {frames} + 1 && bgcView.devices.grips[0].px > 0")
    x, y = view.ask(GRIP)
    mouse = view.page.mouse
    mouse.move(x, y)
    view.until("bgcView.devices.grips[0].hot")
    mouse.down()
    mouse.move(x + 2, y - 60, steps=3)
    view.until("bgcView.row[0] > 0.4 && bgcView.player.held[0] === 'grip'")
    mouse.up()
    # Beyond the end of the scene the run goes on without one.
    view.ask("bgcView.setSpeed(20)")
    view.until("bgcView.player.ended")
    view.ask("{bgcView.setSpeed(1); bgcView.source.send('play')}")
    # A finger at the grip does the same, and scrolls nothing.
    view.until("bgcView.row[0] < 0.35 && bgcView.devices.grips[0].seen[2] === 0")
    fingers = view.context.new_cdp_session(view.page)
    x, y = view.ask(GRIP)
    for kind, dy in (("touchStart", 0), ("touchMove", 30), ("touchMove", 60), ("touchEnd", None)):
        points = [] if dy is None else [{"x": x + 2, "y": y - dy}]
        if dy is None:
            view.until("bgcView.row[0] > 0.4 && bgcView.devices.hands[0].by === 'pointer'")
        fingers.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
    view.until("bgcView.devices.hands[0].by === null")
    # A gamepad takes it from the pointer, and the recorded motion has it again.
    view.page.evaluate(STICK, 0.9)
    view.until("bgcView.row[0] < 0.2 && bgcView.devices.hands[0].by === 'gamepad'")
    view.page.evaluate("navigator.getGamepads = () => []")
    view.page.get_by_label("Give grip back to trace").click()
    view.until("bgcView.player.held.length === 0")
    # A slider; a value out of range, which is refused with the message of the command line.
    view.ask("bgcView.source.send('set', {name: 'length', value: 8})")
    view.until("bgcView.parameters.values[0] === 8 && bgcView.row[4] < 6 - 7")
    # The bond graph has the power of each bond, from a module of its own.
    view.page.keyboard.press("g")
    view.until("bgcView.graph.values?.length === 6 && bgcView.graph.edges.length === 3")
    assert view.page.get_by_role("tab", name="Slots").count() == 0
    powers = """(() => { const { graph, row } = bgcView; const power = (name) => graph.power(
      graph.edges.find((e) => graph.nameOf(e.edge) === name).edge);
      return [row[5], ...["supply -> loop", "loop -> wire", "loop -> store"].map(power)]; })()"""
    view.page.get_by_label("Pause").click()
    view.until("!bgcView.player.playing")
    view.page.get_by_label("One step").click()
    view.page.wait_for_timeout(300)
    store, given, lost, stored = view.ask(powers)
    current = (8 - store) / 2000
    assert 2 < store < 8 and given == pytest.approx(8 * current, rel=1e-4)
    assert (lost, stored) == pytest.approx((2000 * current**2, store * current), rel=1e-4)
    view.page.keyboard.press("g")
    view.page.keyboard.press("Space")
    view.ask("bgcView.source.send('set', {name: 'length', value: 9})")
    view.until("!document.querySelector('.banner').hidden")
    with pytest.raises(BgError) as raised:
        model.parameters["length"] = 9.0
    shown = view.page.locator(".banner").inner_text()
    assert f"BG061 {raised.value.diagnostics[0].message}" in shown
    # A failed step is explained; the rows stay; a reset begins again with the values that were set.
    view.ask("bgcView.source.send('set', {name: 'limit', value: 0.1})")
    view.ask("bgcView.source.send('hand', {device: 'grip', position: [0, 0, 3]})")
    view.until("document.querySelector('.banner').innerText.includes('BG705')")
    text = view.page.locator(".banner").inner_text()
    assert re.search(r"BG705 too fast \(at t = [\d.]+ s\)$", text, re.MULTILINE), text
    assert view.ask("bgcView.store.count") > 10 and not view.ask("bgcView.player.playing")
    view.ask("bgcView.source.send('set', {name: 'limit', value: 100})")
    view.page.get_by_label("Reset (R)").click()
    view.until("bgcView.player.epoch === 2 && bgcView.store.count === 1")
    assert view.ask("bgcView.parameters.values[0]") == 8
    # A worker that does not obey is replaced, and the new one knows the values.
    view.ask("bgcView.source.send('set', {name: 'length', value: 5})")
    view.ask("{bgcView.source.post = () => {}; bgcView.source.send('reset')}")
    view.until("bgcView.player.epoch === 3 && bgcView.player.ready && bgcView.store.count === 1")
    assert view.ask("bgcView.parameters.values[0]") == 5
    view.close(("file://",))


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium")
def test_a_frame_without_workers_and_gamepads_runs_the_model_in_the_page(browser, live):
    context = browser.new_context(viewport={"width": 320, "height": 240})
    context.add_init_script(
        "delete window.Worker; navigator.getGamepads = () => { throw new Error('not allowed'); }"
    )
    page = context.new_page()
    wrong = []
    page.on("pageerror", lambda e: wrong.append(str(e)))
    page.goto(f"{live.as_uri()}?quality=low")
    end = time.monotonic() + 40
    for wanted in ("bgcView.frames > 1", "bgcView.source.send('play')", "bgcView.store.last > 0"):
        asked = f"Boolean(window.bgcView?.store?.count) && ({wanted}) !== false"
        while not page.evaluate(asked):
            assert time.monotonic() < end, (wanted, wrong)
            time.sleep(0.1)
    context.close()
    assert wrong == []


@pytest.mark.slow  # zig takes 40 s of processor time: nothing else builds the page that is promised
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium")
def test_the_page_of_the_papers_crane_is_below_a_megabyte(browser, tmp_path):
    file = library_folder() / "scenes/two_beam_crane.bg"
    page = live_page(file, Options("two_beam_crane"))
    assert 3e5 < len(gzip.compress(page.document.encode())) < 1e6
    path = page.save(tmp_path / "crane.html")
    view = View(browser, f"{path.as_uri()}?quality=low", offline=True)
    times = [0.05 * k for k in range(101)]
    done = view.ask(f"bgcView.source.simulate({times})")
    crane = bgc.compile(file, scene="two_beam_crane", shapes=True)
    native = np.full((101, crane.row_width), np.nan)
    method = with_capped_step(method_of(crane)[0], np.array(times), True)
    with crane.started(method, bool(crane.accounts)) as run:
        assert run.run(np.array(times), native) == (Status.OK, 101)
    assert np.ptp(native, axis=0).max() > 0.1
    np.testing.assert_allclose(np.array(done["rows"]), native, rtol=1e-6, atol=1e-6)
    view.close(("file://",))


# --- its data ---------------------------------------------------------------------------------


def test_a_page_is_one_small_document_for_notebooks_too(live, file, monkeypatch):
    document = live.read_text("utf-8")
    assert (
        len(gzip.compress(document.encode())) < 5e5
    )  # the script, two modules; cranes have 0.7 MB
    assert "default-src 'none'" in document and not re.search(r'(src|href)="http', document)
    page = LivePage("a <b>", '<p title="x">', height=300)
    shown = page._repr_html_()
    assert 'srcdoc="&lt;p title=&quot;x&quot;&gt;"' in shown and "height:300px" in shown
    assert page.save(file.parent / "saved.html").read_text("utf-8") == '<p title="x">'


def test_a_model_shows_its_page_with_its_present_parameters(model, live):
    again = bgc.compile(model.origin[0], scene="lift")
    again.parameters["length"] = "3 m"
    document = again.live(height=100).document  # the module comes from the cache
    content = json.loads(re.search(r'id="model">(.*?)</script>', document)[1])
    assert content["given"] == [[0, 3.0]] and content["values"][0] == 3.0
    assert content["devices"][0]["text"] == TRACE


def test_messages_are_those_of_the_command_line(model):
    faults = fault_messages(model, model.places)
    with model.started(method_of(model)[0], False, {"limit": 0.1}) as instance:
        at = {state.name: k for k, state in enumerate(model.states)}
        instance.state[[at["angle"], at["rate"]]] = 0.0, 5.0
        assert instance.restart() is Status.OK
        rows = np.empty((1, model.row_width))
        status, _ = instance.run(np.array([1.0]), rows)
    told = explain(instance, status, model.places)
    entry = faults["by_status"][str(int(Status.ASSERTION))]
    assert entry["names"] == 1
    template = entry["items"]["0"]
    assert template["text"].replace("⟦time⟧", f"{instance.time:.9g}") == told.message
    assert template["code"] == told.code and template["help"] == told.help
    known = {int(key) for key in faults["by_status"]}
    silent = {Status.OK, Status.BAD_ARGUMENT, Status.INTERRUPTED}
    # Of sensitivities and of other tools' FMUs, which a page does not have.
    silent |= {Status.GRAZING, Status.SIMULTANEOUS, Status.FMU}
    assert known == {int(s) for s in Status} - {int(s) for s in silent}
    state = faults["by_status"][str(int(Status.NOT_FINITE))]
    assert "⟦state⟧" in state["named"]["text"] and "⟦state⟧" not in state["any"]["text"]
    device = faults["by_status"][str(int(Status.DEVICE))]
    assert "`grip`" in device["items"]["0"]["text"] and "⟦reason⟧" in device["reasons"]["0"]["text"]


def test_a_device_that_no_browser_has_is_the_hand_of_the_page(file):
    far = bgc.compile(file, scene="far", shapes=True)
    settings, _ = run_settings(far)  # looks for no library
    assert settings["devices"] == [{"name": "grip", "driver": "pointer", "options": ""}]
    angle = settings["start"]["state"][settings["states"].index("angle")]
    assert angle == pytest.approx(np.arcsin(0.3))


def code_of(work):
    return refusal(work)


def test_a_page_of_a_large_graph_has_none_and_says_so(model, monkeypatch):
    """With 3,000 masses the layout of 18,000 bonds had taken more than eight minutes."""
    monkeypatch.setattr(page_export, "MOST_BONDS", 2)
    monkeypatch.setattr(page_export, "graph_content", None)  # is not called
    (told,) = model.live().notices
    assert told.code == "BG544" and "has 3 bonds" in told.message


def test_what_cannot_be_a_page_is_refused(file, model, monkeypatch, tmp_path):
    other = Options("other")
    assert code_of(lambda: live_page(file, other)).code == "BG548"
    (tmp_path / "lift.bg").write_text(MODEL, "utf-8")
    lost = code_of(lambda: live_page(tmp_path / "lift.bg", Options("lift")))
    assert lost.code == "BG074" and "grip.csv" in lost.message
    monkeypatch.setattr(modules, "ZIGLANG", ("false",))
    assert code_of(lambda: modules.build_module("int x;", open_cache())).code == "BG547"
    broken = tmp_path / "broken.py"
    broken.write_text("raise ImportError('its files are lost')")
    monkeypatch.setattr(modules, "ZIGLANG", (sys.executable, str(broken)))
    found = code_of(lambda: modules.build_module("int x;", open_cache()))
    assert found.code == "BG547" and "--force-reinstall ziglang" in found.help
    assert found.note == "ImportError: its files are lost"
    monkeypatch.setattr(modules, "find_spec", lambda name: None)
    absent = code_of(model.live)
    assert absent.code == "BG545" and 'pip install "bgc-lang[zig]"' in absent.help


def test_a_gallery_has_a_page_of_each_scene_and_an_index(file, tmp_path, monkeypatch):
    def page_of(path, options):
        if options.scene == "other":
            return live_page(path, options)
        return LivePage(options.scene, f"<p>{options.scene}")

    monkeypatch.setattr(gallery, "live_page", page_of)
    asked = ["doc", "--gallery", str(file), "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(application, asked)
    assert done.exit_code == 1 and "error[BG548]" in done.stderr
    names = ("lift.lift.html", "lift.far.html", "index.html")
    written = [tmp_path / "out" / name for name in names]
    assert done.stdout.split() == [str(path) for path in written]
    assert written[1].read_text("utf-8") == "<p>far"
    index = written[2].read_text("utf-8")
    assert re.findall(r'href="(.+?)"', index) == list(names[:2])
    assert "Swings &lt;fast&gt;." in index and "cannot hold the solver" in index
    assert CliRunner().invoke(application, ["doc", "--gallery", "TF"]).exit_code == 2
    assert CliRunner().invoke(application, ["doc", "--gallery", "--library"]).exit_code == 2
