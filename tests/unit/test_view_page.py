"""The page of `bgc view` in a browser: Debian's Chromium, driven by Playwright."""

import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from chromium import CHROMIUM, View
from model_files import model_text

BGC = (sys.executable, "-c", "from bgc.runtime.cli import main; main()")

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium")

MODEL = model_text("view_page")


# How many plots a frame of 16 ms and one of 500 ms draw where the panel is high enough for all.
TURNS = """() => {
  const view = bgcView, { plots, before } = view, request = window.requestAnimationFrame;
  window.requestAnimationFrame = () => 0;
  plots.holder.getBoundingClientRect = () => ({ top: -1e4, bottom: 1e4 });
  const drawn = (frame) => {
    plots.waiting = [];
    for (const plot of plots.list) plot.now = null;
    [view.before, view.plotted] = [before, -Infinity];
    view.loop(before + frame);
    return plots.list.filter((plot) => plot.now !== null).length;
  };
  const found = [drawn(16), drawn(500)];
  delete plots.holder.getBoundingClientRect;
  [view.before, view.plotted, window.requestAnimationFrame] = [before, before, request];
  return found;
}"""


class Served:
    """The command, with the address that it has printed."""

    def __init__(self, *arguments, command="view"):
        command = [*BGC, command, "--no-browser", *map(str, arguments)]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.url = self.process.stdout.readline().strip()

    def end(self):
        self.process.terminate()
        self.process.wait(10)
        self.process.stdout.close()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("page")
    (path / "lift.bg").write_text(MODEL, "utf-8")
    return path


@pytest.fixture(scope="module")
def live(folder):
    served = Served(folder / "lift.bg")
    yield served
    served.end()


def test_a_live_run_is_seen_steered_and_found_again(browser, live):
    # A page that is closed must not end the command: it ignores SIGPIPE.
    status = Path(f"/proc/{live.process.pid}/status").read_text("ascii")
    ignored = next(line for line in status.splitlines() if line.startswith("SigIgn:"))
    assert int(ignored.split()[1], 16) >> (signal.SIGPIPE - 1) & 1
    view = View(browser, f"{live.url}&quality=low")
    page = view.page
    assert view.colours() > 12
    # Step, play, pause.
    page.get_by_label("One step").click()
    view.until("bgcView.store.count === 2")
    page.keyboard.press("Space")
    view.until("bgcView.store.last > 0.3 && bgcView.player.playing")
    view.until("bgcView.plots.list[0].uplot.data[1][0].length > 10")
    # The right axis has the units of all that it is for.
    label = "(([, , { uplot }]) => uplot.axes[2].label(uplot))(bgcView.plots.list)"
    view.until(f"bgcView.plots.list[2].uplot && {label} === 'rad/s, m'")
    page.get_by_label("Pause").click()
    view.until("!bgcView.player.playing")
    stopped = view.ask("bgcView.store.last")
    assert view.ask("[...bgcView.row]")[0] != pytest.approx(1)
    # Plots take turns where frames are quick; where they are slow, all show the same time.
    assert page.evaluate(TURNS) == [1, 3]
    # A slider moves the load, which hangs lower.
    page.get_by_role("tab", name="Parameters").click()
    height = view.ask("bgcView.row[4]")
    view.check_access()
    view.ask("bgcView.setTheme('dark')")
    view.check_access()
    slider = page.get_by_label("length", exact=True)
    # By the keys alone: to the slider, which takes an arrow for itself, and back to the tabs.
    scrubbed = view.ask("bgcView.shownTime()")
    slider.focus()
    page.keyboard.press("ArrowRight")
    view.until("bgcView.parameters.values[0] > 2")
    assert view.ask("bgcView.shownTime()") == scrubbed
    page.get_by_role("tab", name="Parameters").focus()
    page.keyboard.press("ArrowLeft")
    assert view.ask("document.activeElement.textContent") == "Plots"
    page.keyboard.press("ArrowRight")
    eye = "bgcView.stage.camera.position.toArray()"
    before = view.ask(eye)
    view.ask("bgcView.stage.canvas.focus()")
    page.keyboard.press("ArrowRight")
    assert view.ask(eye) != pytest.approx(before, rel=1e-3)
    page.get_by_label("One step").focus()
    rows = view.ask("bgcView.store.count")
    page.keyboard.press("Space")
    view.until(f"bgcView.store.count === {rows} + 1 && !bgcView.player.playing")
    view.ask("bgcView.setTheme('light')")
    slider.fill("1000")
    view.until("bgcView.parameters.values[0] > 4")
    page.get_by_label("One step").click()
    view.until(f"bgcView.store.last > {stopped} && bgcView.row[4] < {height} - 1")
    # A flood of values: the last one counts, on all pages, and nothing is kept waiting.
    one = "bgcView.source.send('set', { name: 'length', value: 2 + k / 100 })"
    view.ask(f"for (let k = 0; k <= 600; k++) {one}")
    view.until("bgcView.parameters.values[0] === 8")
    # A window as narrow as pages have to be for WCAG.
    page.set_viewport_size({"width": 320, "height": 500})
    assert view.ask("document.documentElement.scrollWidth") == 320
    page.set_viewport_size({"width": 900, "height": 500})
    # Scrub into the past, and back.
    view.ask("bgcView.seek(0.1)")
    view.until("Math.abs(bgcView.row[0] - 1) < 0.1 && bgcView.shownTime() === 0.1")
    page.keyboard.press("End")
    view.until("bgcView.scrubbed === null")
    # A lost connection is said, and found again.
    view.ask("bgcView.source.socket.close()")
    view.until("bgcView.disconnected")
    assert "connects again" in page.locator(".banner").inner_text()
    view.until("!bgcView.disconnected && document.querySelector('.banner').hidden")
    # A page that is loaded again, and a second one, find the same run.
    rows = view.ask("bgcView.store.count")
    page.reload()
    view.until(f"window.bgcView && bgcView.store && bgcView.store.count >= {rows}")
    other = View(browser, f"{live.url}&quality=low")
    other.page.get_by_label("Reset (R)").click()
    view.until("bgcView.player.epoch === 1 && bgcView.store.count === 1")
    # A failed step is explained; the rows stay.
    other.ask("bgcView.source.send('set', {name: 'limit', value: 0.5})")
    other.page.keyboard.press("Space")
    view.until("!document.querySelector('.banner').hidden")
    assert "BG705" in page.locator(".banner").inner_text()
    assert "too fast" in page.locator(".banner").inner_text()
    assert view.ask("bgcView.store.count") > 1
    origin = live.url.split("/?")[0]
    other.close((origin, origin.replace("http", "ws")))
    view.close((origin, origin.replace("http", "ws")))


def test_a_recorded_run_is_replayed_and_kept_as_one_file(browser, folder):
    run = [*BGC, "run", str(folder / "lift.bg"), "--shapes", "--quiet"]
    subprocess.run([*run, "--out", str(folder / "lift.npz")], check=True)
    served = Served(folder / "lift.npz")
    try:
        view = View(browser, f"{served.url}&quality=low")
        assert view.ask("[bgcView.live, bgcView.store.count]") == [False, 101]
        view.ask("bgcView.seek(2.025)")
        view.until("bgcView.row[0] !== 1 && bgcView.shownTime() === 2.025")
        rows = view.ask("[40, 41].map((k) => bgcView.store.data[k * bgcView.store.width + 2])")
        angle = view.ask("bgcView.row[0]")
        assert angle == pytest.approx(sum(rows) / 2, abs=1e-5)
        view.page.keyboard.press("Space")
        view.until("bgcView.time > 2.2")
        with view.page.expect_download() as download:
            view.page.get_by_label("Save a replay").click()
        download.value.save_as(folder / "saved.html")
        view.ask("(() => { CompressionStream = () => { throw new Error('no room') } })()")
        view.page.get_by_label("Save a replay").click()
        view.until("!document.querySelector('.banner').hidden")
        assert "The replay could not be saved" in view.page.locator(".banner").inner_text()
        view.close((served.url.split("/?")[0], served.url.split("/?")[0].replace("http", "ws")))
    finally:
        served.end()
    export = [*BGC, "view", str(folder / "lift.npz"), "--export"]
    subprocess.run([*export, str(folder / "lift.html")], check=True, capture_output=True)
    for name in ("saved.html", "lift.html"):
        alone = View(browser, f"{(folder / name).as_uri()}?quality=low", offline=True)
        assert alone.ask("[bgcView.live, bgcView.store.count]") == [False, 101]
        assert alone.colours() > 12
        alone.close(("file://",))


SWING = """
model Swing { state x = 1; state v = 0; der(x) = v; der(v) = -x; }
scene swing of Swing { observe x, v; plot x; plot v against x; run 20 every 0.1; }
"""


def test_errors_are_a_band_and_stand_beside_the_value(browser, folder):
    (folder / "swing.bg").write_text(SWING)
    out = folder / "swing.html"
    command = [*BGC, "view", str(folder / "swing.bg"), "--export", str(out), "--solver", "heun"]
    subprocess.run([*command, "--step", "0.1"], check=True, capture_output=True)
    view = View(browser, out.as_uri(), offline=True)
    view.ask("bgcView.seek(20)")
    view.until("bgcView.plots.list[0].uplot.data[1].length > 100 && bgcView.row[2] > 0")
    x, below, above = view.ask("bgcView.plots.list[0].uplot.data.slice(1).map((y) => y.at(-1))")
    error = view.ask("bgcView.row[2]")
    assert error == pytest.approx(20 * 0.1**2 / 6, rel=0.5)  # of the phase, and so of x at most
    assert (above - x, x - below) == pytest.approx((error, error), rel=1e-5)
    assert re.search(r"± 0\.0\d$", view.page.locator(".plot .value").first.inner_text())
    # Nothing else is drawn where curves are against each other.
    assert view.ask("bgcView.plots.list[1].uplot.series.length") == 2
    view.check_access()
    view.close(("file://",))


HAND = model_text("view_page_hand")


def test_modes_are_listed_and_swing_the_shapes(browser, folder):
    out = folder / "modes.html"
    command = [*BGC, "view", str(folder / "lift.bg"), "--modes", "--steady", "--export", str(out)]
    subprocess.run(command, check=True, capture_output=True)
    view = View(browser, f"{out.as_uri()}?quality=low", offline=True)
    page = view.page
    page.wait_for_selector(".mode")
    assert page.locator(".mode").count() == 1
    assert "0.4985 Hz" in page.locator(".mode").inner_text()
    times = []
    for _ in range(12):
        times.append(view.ask("bgcView.time"))
        page.wait_for_timeout(150)
    assert all(0 <= time <= 2 for time in times)  # s of the cycle, again and again
    assert len(set(times)) > 4
    view.close(("file://",))


@pytest.fixture
def arm(folder):
    (folder / "arm.bg").write_text(HAND, "utf-8")
    (folder / "bad.glb").write_text("damaged")
    (folder / "still.csv").write_text("time,x,y,z\n0,0,0,0\n1,0,0,0\n")
    return folder / "arm.bg"


def test_a_hand_is_dragged_and_its_force_is_seen(browser, arm):
    served = Served(arm)
    try:
        view = View(browser, f"{served.url}&quality=low")
        view.until("bgcView.bannerBox.innerText.includes('The mesh bad.glb is not drawn')")
        view.page.get_by_label("Close").click()
        mouse = view.page.mouse
        view.until("bgcView.devices.grips.length === 1 && bgcView.devices.grips[0].px > 0")
        place = """(() => { const [g] = bgcView.devices.grips;
          const b = g.stage.canvas.getBoundingClientRect();
          const p = g.onScreen(g.knob.position); return [b.left + p.x, b.top + p.y]; })()"""
        # Dragged up on the screen, the tip goes up; the run starts by itself.
        assert view.ask("bgcView.devices.grips[0].label.hidden")
        x, y = view.ask(place)
        camera = view.ask("bgcView.stage.camera.position.toArray()")
        mouse.move(x, y)
        mouse.down()
        mouse.move(x + 2, y - 60, steps=3)
        view.until("bgcView.row[2] > 2.2 && bgcView.player.playing")
        view.until(
            "!bgcView.devices.grips[0].label.hidden && bgcView.devices.grips[0].shaft.visible"
        )
        assert view.page.locator(".force").inner_text().endswith(" N")
        assert view.ask("bgcView.player.held") == ["hand"]
        now = view.ask("bgcView.stage.camera.position.toArray()")
        assert now == pytest.approx(camera, rel=1e-9)  # the camera stays
        # A page that is hidden draws no frames, so it lets go first.
        assert view.ask(
            """(() => { const [hand] = bgcView.devices.hands; const before = hand.position[2];
            Object.defineProperty(document, "hidden", { value: true, configurable: true });
            document.dispatchEvent(new Event("visibilitychange"));
            delete document.hidden;
            return before > 0 && hand.by === null && hand.position.every((x) => x === 0); })()"""
        )
        mouse.up()
        view.until("bgcView.devices.hands[0].position.every((x) => x === 0)")
        view.until("bgcView.devices.grips[0].seen.every((x) => x === 0)")
        # A video of what is seen.
        view.page.keyboard.press("v")
        shown = view.ask("bgcView.frames")
        view.until(f"bgcView.frames > {shown} + 12 && bgcView.saving.video.seconds > 0.3")
        with view.page.expect_download() as video:
            view.page.keyboard.press("v")
        data = Path(video.value.path()).read_bytes()
        assert video.value.suggested_filename == "arm.webm"
        assert data[:4] == bytes.fromhex("1a45dfa3") and len(data) > 2000
        # A gamepad takes it, and its stick leaves it in the middle.
        height = view.ask("bgcView.row[2]")
        stick = """(down) => { navigator.getGamepads = () => [{ connected: true,
          axes: [0, 0, 0, down], buttons: new Array(8).fill({ pressed: false, value: 0 }) }]; }"""
        view.page.evaluate(stick, 0.9)
        view.until(f"bgcView.row[2] < {height} - 0.1 && bgcView.devices.hands[0].by === 'gamepad'")
        view.page.evaluate(stick, 0.0)
        view.until("bgcView.devices.grips[0].seen[2] === 0")
        # The pad beside the scene moves it ahead; then the trace has the device again.
        flat = view.page.locator(".handle g.flat").bounding_box()
        view.page.evaluate("navigator.getGamepads = () => []")
        mouse.move(flat["x"] + 52, flat["y"] + 52)
        mouse.down()
        mouse.move(flat["x"] + 52, flat["y"] + 30)
        view.until("bgcView.row[0] > 0.05 && bgcView.row[3] > 0.02")
        mouse.up()
        view.page.get_by_label("Give hand back to trace").click()
        view.until("bgcView.player.held.length === 0 && !bgcView.devices.hands[0].taken")
        origin = served.url.split("/?")[0]
        origins = (origin, origin.replace("http", "ws"))
        view.close(origins)
        check_tilting(View(browser, f"{served.url}&quality=low", has_touch=True), origins)
    finally:
        served.end()


def test_a_loop_in_real_time_is_seen_and_steered(browser, arm):
    """Pages come and go beside the loop, which waits for none of them."""
    given = ["--view", "--device", "hand=pointer", "--quiet", "--watchdog", "0 s"]
    served = Served(arm, *given, command="haptic")
    origins = (served.url.split("/?")[0], served.url.split("/?")[0].replace("http", "ws"))
    try:
        one, other = (View(browser, f"{served.url}&quality=low") for _ in "ab")
        one.until("bgcView.devices.grips[0]?.px > 0 && bgcView.store.last > 0.1")
        assert one.page.locator(".badge").inner_text().startswith("real time")
        assert one.page.get_by_label("One step").is_hidden()
        flat = one.page.locator(".handle .high").bounding_box()
        mouse = one.page.mouse
        mouse.move(flat["x"] + flat["width"] / 2, flat["y"] + flat["height"] / 2)
        mouse.down()
        mouse.move(flat["x"] + flat["width"] / 2, flat["y"] + 2, steps=3)
        for view in (one, other):  # the tip of both rises, and the force pulls it down
            view.until("bgcView.row[2] > 2.2 && bgcView.player.held[0] === 'hand'")
        # The page that holds the device is killed: the other one sees the hand in the middle.
        one.close(origins)
        other.until("bgcView.player.held.length === 0 && bgcView.devices.grips[0].seen[2] === 0")
        before = other.ask("bgcView.store.last")
        other.until(f"bgcView.store.last > {before}")
        other.page.keyboard.press("r")
        other.until("bgcView.player.epoch === 1 && bgcView.store.last > 0 && bgcView.row[2] === 2")
        served.end()
        other.until("bgcView.disconnected && !bgcView.bannerBox.hidden")
        assert "The loop has ended" in other.page.locator(".banner").inner_text()
        other.wrong[:] = [text for text in other.wrong if "WebSocket" not in text]
        other.close(origins)
    finally:
        served.end()


def check_tilting(view, origins):
    """A tablet is held at 35 degrees and tilted by 16: half of the reach, behind 2."""
    view.until("!bgcView.bannerBox.hidden")
    view.page.get_by_label("Close").click()
    key = view.page.get_by_label("Tilt the screen to move it")
    for answer, told in (("denied", "not allowed"), ("granted", "no sensor")):
        view.ask(f"DeviceOrientationEvent.requestPermission = async () => '{answer}'; 0")
        key.click()
        view.until(f"document.querySelector('.handle small').textContent === '{told}'")
        assert key.get_attribute("aria-pressed") == "false"
    tilt = """([alpha, beta, gamma, angle]) => {
      Object.defineProperty(screen.orientation, "angle", { value: angle, configurable: true });
      dispatchEvent(new DeviceOrientationEvent("deviceorientation", { alpha, beta, gamma })); }"""
    place = "(([hand]) => hand.position.map((x) => x / hand.device.reach))(bgcView.devices.hands)"
    for angle, postures in (
        (0, ([0, 19, 0], [0, 51, 0], [0, 35, 0])),
        (90, ([90, 0, -19], [90, 0, -51], [90, 0, -35])),  # the top of the tablet is at the left
    ):
        key.click()
        view.page.evaluate(tilt, [*postures[2], angle])
        for posture, ahead in zip(postures, (0.5, -0.5, 0.0), strict=True):
            view.page.evaluate(tilt, [*posture, angle])
            assert view.ask(place) == pytest.approx([ahead, 0, 0], abs=1e-9), posture
            assert view.ask("bgcView.devices.hands[0].by") == "tilt"
        key.click()
        assert view.ask("bgcView.devices.hands[0].by") is None
    # Held flat: to the left side, and turned clockwise; the model follows.
    key.click()
    view.page.evaluate(tilt, [10, 0, 0, 0])
    view.page.evaluate(tilt, [10, 0, -16, 0])
    assert view.ask(place) == pytest.approx([0, 0.5, 0], abs=1e-9)
    view.page.evaluate(tilt, [354, 0, 0, 0])
    assert view.ask(place) == pytest.approx([0, 0, 0.5], abs=1e-9)
    view.until("bgcView.row[5] > 0.02 && bgcView.player.held[0] === 'hand'")
    view.ask("bgcView.devices.letGo()")
    assert key.get_attribute("aria-pressed") == "false"
    view.until("bgcView.row[5] === 0")
    view.close(origins)


def test_a_circuit_has_its_plots_its_graph_and_its_slots(browser, folder):
    (folder / "rc.bg").write_text(
        """interface Part { port p in; }
        model Plain is Part { port p in; param ohms = 2 ohm; r : R(ohms); p -> r; }
        model Warm is Part { port p in; param ohms = 2 ohm; r : R(1.5*ohms); p -> r; }
        model RC { param volts = 5 V; input x[3] : m; supply : Se(e = volts + x[3]*(1 V/m));
        loop : J1; resistor : Part = Plain; capacitor : C(10 uF);
        supply -> loop -> resistor; loop -> capacitor; }
        scene charge of RC { device hand = pointer(); drive x = hand.position;
        observe capacitor.e, loop.f; run 0.1 ms; }""",
        "utf-8",
    )
    served = Served(folder / "rc.bg")
    try:
        view = View(browser, served.url)
        assert view.ask("document.querySelectorAll('main .plot').length") == 2
        assert view.ask("bgcView.stage === undefined")
        plots, pad = (view.page.locator(f"main .{name}") for name in ("plots", "hands"))
        assert plots.bounding_box()["y"] + plots.bounding_box()["height"] <= pad.bounding_box()["y"]
        view.ask("bgcView.setSpeed(1e-4)")
        view.page.keyboard.press("Space")
        view.until("bgcView.player.ended")
        last = view.ask("bgcView.store.last")
        assert last == pytest.approx(1e-4)
        # The bond graph: widths by power, efforts and flows of the bond that is clicked.
        view.page.keyboard.press("g")
        view.until("bgcView.graph.values && bgcView.graph.edges.length === 3")
        power = "(name) => bgcView.graph.edges.find((e) => bgcView.graph.nameOf(e.edge) === name)"
        width = f"(name) => parseFloat(({power})(name).line.style.strokeWidth)"
        names = ("supply -> loop", "loop -> capacitor", "loop -> resistor.r")
        given, stored, lost = (view.page.evaluate(width, name) for name in names)
        assert given > lost > 1 and given > stored > 1
        line = view.page.locator("svg.graph .bond", has_text="loop -> capacitor").locator(".target")
        line.dispatch_event("click")
        card = view.page.locator(".card").inner_text()
        effort = view.ask("bgcView.row[0]")
        assert f"{effort:.4g}" in card and "Stroke at the tail" in card and "line 6" in card
        view.check_access()
        view.page.locator("svg.graph .node", has_text="capacitor").dispatch_event("click")
        view.until("!document.querySelector('.chosen').hidden")
        assert "capacitor : C(10 uF)" in view.page.locator(".chosen").inner_text()
        # Another part in the slot: the page comes back, also where all it describes is the same.
        view.ask("bgcView.source.send('set', {name: 'volts', value: 6}); window.before = true")
        view.page.get_by_role("tab", name="Slots").click()
        view.ask("bgcView.source.send('play')")
        view.page.get_by_label("resistor").select_option("Warm")
        view.until("bgcView.player.busy === 'model' && bgcView.player.playing")
        during = view.ask("bgcView.store.last")
        view.until(f"bgcView.player.busy === 'model' && bgcView.store.last > {during}")
        view.until("!window.before && window.bgcView?.description")
        view.until("bgcView.store.count >= 1 && bgcView.player.epoch === 1")
        view.until("bgcView.graph.shown && bgcView.tabs.chosen === 1 && bgcView.store.last > 0")
        view.until("bgcView.parameters.values.includes(6)")  # the slider keeps its value
        view.until("bgcView.graph.graph")
        # The file is edited and broken meanwhile: the page shows the lines at fault.
        broken = (folder / "rc.bg").read_text("utf-8").replace("C(10 uF)", "C(10 uF")
        (folder / "rc.bg").write_text(broken, "utf-8")
        view.page.get_by_label("resistor", exact=True).select_option("Plain")
        view.until("bgcView.player.busy === 'model'")
        view.until("document.querySelector('.banner pre')")
        assert "5 |" in view.page.locator(".banner pre").first.inner_text()
        assert view.page.get_by_label("resistor", exact=True).input_value() == "Warm"
        assert view.ask("bgcView.player.epoch") == 1
        # The command ends: the page says so.
        served.end()
        view.until("bgcView.disconnected")
        assert "start it again" in view.page.locator(".banner").inner_text()
        view.wrong[:] = [text for text in view.wrong if "WebSocket" not in text]
        view.close((served.url.split("/?")[0], served.url.split("/?")[0].replace("http", "ws")))
    finally:
        served.end()
