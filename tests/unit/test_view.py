"""Live runs, their messages and their server, without a browser."""

import asyncio
import json
import re
import struct
import subprocess
import sys
import threading
import time
import zlib
from base64 import b64decode
from pathlib import Path

import aiohttp
import numpy as np
import pytest
from click.testing import CliRunner
from view_server import address, home, serving

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.cli.app import application
from bgc.runtime.running.devices import read_choices
from bgc.runtime.running.simulate import method_of
from bgc.runtime.view import page as pages
from bgc.runtime.view.description import describe_model, meshes_of, panels_of
from bgc.runtime.view.history import History, as_rows
from bgc.runtime.view.live import LiveRun
from bgc.runtime.view.player import FRAME, Player, usual_speed
from bgc.runtime.view.protocol import HEADER, pack_rows, read_command
from bgc.runtime.view.recording import read_recording
from bgc.runtime.view.server import Client, Server

MODEL = """
model Swing {
  param length = 2 m in 0.5 m .. 8 m;
  param limit = 10 rad/s;
  param angle0 = 30 deg;
  param g = 9.81 m/s^2;
  state angle = angle0;
  state rate : rad/s = 0 rad/s;
  der(angle) = rate;
  der(rate) = -g/length*sin(angle);
  assert abs(rate) < limit, "too fast";
  signal bob[3] : m = [length*sin(angle), 0, -length*cos(angle)];
  shape sphere(0.2 m) at bob colour "red";
  shape sea([[0.5 m, 1, 0, 0]]);
}
scene swing of Swing {
  observe angle in deg, bob as bob, rate;
  plot angle;
  plot rate against angle;
  solver rodas5p(rtol = 1e-8);
  run 3 s every 0.1 s;
}
"""


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("view") / "swing.bg"
    path.write_text(MODEL, "utf-8")
    return path


@pytest.fixture(scope="module")
def model(file):
    return bgc.compile(file, shapes=True)


@pytest.fixture
def run(model):
    run = LiveRun(model, method_of(model)[0], {})
    yield run
    run.close()


@pytest.fixture
def script(monkeypatch):
    """A page without its bundle, which these tests do without."""
    monkeypatch.setattr("bgc.runtime.view.server.bundle", lambda: "'</script>'")


# --- live runs --------------------------------------------------------------------------------


def test_a_run_in_pieces_has_the_bits_of_a_whole_one(model, run):
    whole = model.simulate()
    first = run.reset()
    pieces = [first[None]]
    for start in range(1, 31, 7):
        rows, fault = run.advance(whole.time[start : start + 7])
        assert fault is None
        pieces.append(rows)
    rows = np.vstack(pieces)
    places = model.selection().places
    assert run.time == whole.time[-1]
    for name, place in zip(whole, places, strict=True):
        np.testing.assert_array_equal(rows[:, place], whole[name])


def test_a_parameter_changes_the_motion_and_keeps_the_state(model, run):
    before = run.reset()
    place = dict(zip((v.name for v in model.outputs), model.selection().places, strict=True))
    run.advance(np.array([0.2]))
    (row,), _ = run.advance(np.array([0.4]))
    run.set_parameter("length", "8 m")
    (after,), _ = run.advance(np.array([0.4]))
    for name in ("angle [deg]", "rate"):
        assert after[place[name]] == pytest.approx(row[place[name]], rel=1e-9)
    assert run.values()[list(model.parameters).index("length")] == 8
    # Slower with the longer rope, against the small swing's own rate of change.
    (later,), _ = run.advance(np.array([0.401]))
    slope = (later[place["rate"]] - after[place["rate"]]) / 1e-3
    angle = np.radians(after[place["angle [deg]"]])
    assert slope == pytest.approx(-9.81 / 8 * np.sin(angle), rel=3e-3)
    again = run.reset()
    assert again[place["bob[3]"]] == pytest.approx(4 * before[place["bob[3]"]])


def test_a_refused_value_leaves_the_run_as_it_is(model, run):
    run.reset()
    (row,), _ = run.advance(np.array([0.3]))
    with pytest.raises(BgError, match="outside"):
        run.set_parameter("length", 99.0)
    with pytest.raises(BgError, match="no parameter"):
        run.set_parameter("lenght", 1.0)
    assert run.given == {}
    (same,), _ = run.advance(np.array([0.3]))
    np.testing.assert_array_equal(same, row)


def test_a_value_that_the_state_contradicts_is_taken_back(tmp_path):
    path = tmp_path / "loop.bg"
    path.write_text(
        """model M { param r = 1 m in 0 m .. 9 m; state y : m = 2 m; unknown z = 1 m;
        der(y) = -0.1*y/(1 s); equation z^2 = y^2 - r^2; }
        scene s of M { observe y, z; solver rodas5p; run 3 s; }""",
        "utf-8",
    )
    looped = bgc.compile(path)
    run = LiveRun(looped, method_of(looped)[0], {})
    run.reset()
    run.advance(np.array([0.1]))
    with pytest.raises(BgError) as raised:
        run.set_parameter("r", 5.0)
    assert [d.code for d in raised.value.diagnostics] == ["BG755"]
    (row,), fault = run.advance(np.array([0.2]))
    assert fault is None and row[1] ** 2 == pytest.approx(row[0] ** 2 - 1, rel=1e-5)
    run.close()


def test_a_live_run_knows_what_its_start_has_found(tmp_path):
    (tmp_path / "v.bg").write_text(
        """model V { param volts = 10 V; state x : V = 4 V; der(x) = (volts - x)/(1 s); }
        scene v of V { observe x; start rest hold x vary volts; run 1 s; }""",
        "utf-8",
    )
    rested = LiveRun(found := bgc.compile(tmp_path / "v.bg"), method_of(found)[0], {})
    rested.reset()
    assert rested.varied == {"volts": pytest.approx(4)} and rested.given == {}
    rested.close()


def test_an_interrupted_run_continues_behind_its_last_good_state(model):
    fixed = LiveRun(model, method_of(model, "rk4", {"step": 1e-5})[0], {})
    fixed.reset()
    threading.Timer(0.02, fixed.stop).start()
    rows, fault = fixed.advance(np.array([2000.0]))
    assert len(rows) == 0 and fault is None and 0 < fixed.time < 2000
    rows, fault = fixed.advance(np.array([fixed.time + 1e-4]))
    assert len(rows) == 1 and fault is None
    fixed.set_parameter("length", 3.0)
    rows, fault = fixed.advance(np.array([fixed.time + 1e-4]))
    assert len(rows) == 1 and fault is None
    fixed.close()


# --- the player -------------------------------------------------------------------------------


class Seen:
    """The rows that a player has published."""

    def __init__(self):
        self.events = []

    def __call__(self, kind, content):
        self.events.append((kind, content))

    def rows(self):
        found = [content for kind, content in self.events if kind == "rows"]
        return np.vstack([rows for _, rows in found]) if found else np.empty((0, 2))

    def wait(self, wanted, seconds=20.0):
        end = time.monotonic() + seconds
        while not wanted(self):
            assert time.monotonic() < end, self.events[-3:]
            time.sleep(0.005)


@pytest.fixture
def played(run):
    seen = Seen()
    player = Player(run, seen)
    player.start(run.reset())
    yield player, seen
    player.close()


def test_a_player_plays_to_the_end_of_the_scene_and_on(played):
    player, seen = played
    player.command({"type": "speed", "value": 100.0})
    player.command({"type": "play"})
    seen.wait(lambda s: player.ended)
    times = seen.rows()[:, :2].sum(axis=1, dtype=float)
    assert times[-1] == pytest.approx(3, abs=1e-9) and not player.playing
    assert (np.diff(times) > 0).all() and np.diff(times).max() < 0.11 + FRAME * 100 / 16
    player.command({"type": "play"})
    seen.wait(lambda s: s.rows()[-1, 0] > 3.5)
    player.command({"type": "pause"})
    seen.wait(lambda s: not player.playing)


def test_steps_and_resets(played):
    player, seen = played
    player.command({"type": "step"})
    seen.wait(lambda s: len(s.rows()) == 2)
    assert seen.rows()[-1, 0] == pytest.approx(FRAME)
    player.command({"type": "set", "name": "angle0", "value": 0.1})
    player.command({"type": "reset"})
    seen.wait(lambda s: player.epoch == 1 and s.events[-1][0] == "state")
    epoch, rows = [content for kind, content in seen.events if kind == "rows"][-1]
    assert epoch == 1 and rows[0, 0] == 0 and rows[0, 2] == pytest.approx(np.degrees(0.1))
    player.command({"type": "set", "name": "length", "value": 1e3})
    seen.wait(lambda s: any(kind == "fault" for kind, _ in s.events))
    (fault,) = (content for kind, content in seen.events if kind == "fault")
    assert fault["messages"][0]["code"] == "BG061" and not fault["stopped"]


def test_a_failed_step_stops_the_player_with_its_reason(played):
    player, seen = played
    player.command({"type": "set", "name": "limit", "value": 0.5})
    player.command({"type": "play"})
    seen.wait(lambda s: any(kind == "fault" for kind, _ in s.events))
    (fault,) = (content for kind, content in seen.events if kind == "fault")
    (message,) = fault["messages"]
    assert message["code"] == "BG705" and "too fast" in message["text"] and fault["stopped"]
    assert '| assert abs(rate) < limit, "too fast";' in re.sub(" +", " ", message["excerpt"])
    assert not player.playing and len(seen.rows()) > 2


def test_a_bug_is_shown_and_does_not_end_the_thread(played, monkeypatch):
    player, seen = played
    monkeypatch.setattr(player._run, "advance", lambda times: 1 / 0)
    player.command({"type": "play"})
    seen.wait(lambda s: any(kind == "fault" for kind, _ in s.events))
    fault = next(content for kind, content in seen.events if kind == "fault")
    assert "ZeroDivisionError" in fault["messages"][0]["text"] and not player.playing
    monkeypatch.undo()
    player.command({"type": "step"})
    seen.wait(lambda s: len(s.rows()) == 2)


@pytest.mark.parametrize(
    ("duration", "speed"),
    [(None, 1), (60, 1), (0.01, 1e-3), (0.5, 0.05), (7200, 100), (4e-9, 1e-6)],
)
def test_short_and_long_scenes_are_shown_in_about_ten_seconds(duration, speed):
    assert usual_speed(duration) == pytest.approx(speed)


# --- messages ---------------------------------------------------------------------------------


def test_a_description_refers_to_the_columns_of_a_row(model):
    found = describe_model(model, "swing.bg")
    json.dumps(found, allow_nan=False)
    assert found["width"] == model.row_width and found["duration"] == 3
    sphere, sea = found["shapes"]
    assert sphere["values"]["radius"] == {"shape": [], "numbers": [0.2]}
    assert len(sphere["values"]["r"]["columns"]) == 3 and sea["kind"] == "sea"
    names = [q["name"] for q in found["observed"]]
    assert names == ["angle [deg]", "bob[1]", "bob[2]", "bob[3]", "rate"]
    assert found["observed"][0]["unit"] == "deg"
    assert found["panels"] == [
        {"quantities": [0], "across": None},
        {"quantities": [4], "across": 0},
        {"quantities": [1, 2, 3], "across": None},
    ]
    length = next(p for p in found["parameters"] if p["name"] == "length")
    assert (length["low"], length["high"], length["unit"]) == (0.5, 8, "m")
    free = next(p for p in found["parameters"] if p["name"] == "limit")
    assert free["low"] is None


def test_energies_share_a_panel_that_the_residual_does_not_disturb():
    names = ("energy.stored", "energy.residual", "energy.supplied", "force")
    observed = [{"name": n, "unit": "N" if n == "force" else "J"} for n in names]
    assert [p["quantities"] for p in panels_of((), observed)] == [[0, 2], [1], [3]]


def test_rows_are_packed_with_times_to_the_nanosecond():
    times = np.array([0.0, 3600.000000001])
    rows = as_rows(times, np.array([[1.0, 2], [3, 4]]))
    message = pack_rows(1, 7, rows, 12.5)
    assert HEADER.unpack_from(message) == (1, 7, 2, 4, 12.5)
    numbers = struct.unpack("<8f", message[HEADER.size :])
    assert numbers[4] + numbers[5] == pytest.approx(times[1], abs=1e-9)
    assert numbers[2:4] == (1, 2)


def test_a_history_thins_itself_and_keeps_its_span():
    history = History(4, limit=16 * 1000)
    for k in range(100):
        history.append(as_rows(np.arange(50.0) + 50 * k, np.zeros((50, 2))))
    times = history.rows[:, 0]
    assert 250 <= len(times) <= 1000
    assert times[0] == 0 and times[-1] >= 4900 and (np.diff(times) > 0).all()
    history.clear()
    assert len(history.rows) == 0


@pytest.mark.parametrize(
    "text",
    [
        "", "[]", "1", "{}", '{"type": "close"}', '{"type": "speed"}',
        '{"type": "speed", "value": 0}', '{"type": "speed", "value": "1"}',
        '{"type": "speed", "value": true}', '{"type": "set", "value": 1}',
        '{"type": "set", "name": "a", "value": NaN}', "[" * 4000, '{"type": ["play"]}',
        '{"type": "set", "name": "a", "value": Infinity}',
        f'{{"type": "set", "name": "a", "value": -1{"0" * 400}}}',
        '{"type": "hand", "device": "a", "position": [0, 0, 0], "orientation": null}',
        f'{{"type": "hand", "device": "a", "position": [0, 0, 1{"0" * 400}]}}',
    ],
)  # fmt: skip
def test_other_messages_are_ignored(text):
    assert read_command(text) is None


def test_messages_of_the_page_are_read():
    assert read_command('{"type": "play"}') == {"type": "play"}
    text = '{"type": "set", "name": "a.b", "value": 2}'
    assert read_command(text) == {"type": "set", "name": "a.b", "value": 2}


# --- the server -------------------------------------------------------------------------------


async def receive(socket, *kinds):
    """The messages up to the first of each kind; rows have the kind `rows`."""
    found = {}
    while not set(kinds) <= set(found):
        message = await socket.receive(timeout=10)
        if message.type is aiohttp.WSMsgType.BINARY:
            found["rows"] = message.data
        else:
            content = json.loads(message.data)
            found[content["type"]] = content
    return found


def test_clients_share_a_live_run_and_come_back(model, run, script):
    server = Server(describe_model(model, "swing.bg"), [])
    player = Player(run, server.publish)
    server.attach(player)
    first = run.reset()

    async def visit(session):
        player.start(first)
        one = await session.ws_connect(address(server, "/ws"), headers=home(server))
        greeting = await receive(one, "scene", "rows", "state")
        assert greeting["scene"]["live"] and not greeting["state"]["playing"]
        two = await session.ws_connect(address(server, "/ws"), headers=home(server))
        await receive(two, "scene", "rows", "state")
        await one.send_str("nonsense")
        await one.send_str('{"type": "play"}')
        for client in (one, two):
            rows = (await receive(client, "state", "rows"))["rows"]
            kind, epoch, count, width, _ = HEADER.unpack_from(rows)
            assert (kind, epoch, width) == (1, 0, 2 + model.row_width)
            assert len(rows) == HEADER.size + 4 * count * width
        await one.close()
        await asyncio.sleep(0.1)
        assert len(server._clients) == 1
        again = await session.ws_connect(address(server, "/ws"), headers=home(server))
        kind, _, count, _, _ = HEADER.unpack_from((await receive(again, "rows"))["rows"])
        assert kind == 2 and count > 2  # all that has happened meanwhile

    try:
        asyncio.run(serving(server, visit))
    finally:
        player.close()


def test_a_client_that_does_not_read_misses_rows_and_no_news(model, script):
    class Full:
        size = 0

        def get_write_buffer_size(self):
            return self.size

    async def check():
        server = Server(describe_model(model, "swing.bg"), [])
        client = Client(None, Full())
        server._clients.add(client)
        rows = np.zeros((1, 2 + model.row_width), np.float32)
        server._on_event("rows", (0, rows))
        Full.size = 10**6
        server._on_event("rows", (0, rows))
        server._on_event("state", {"playing": False})
        kinds = [type(client._messages.get_nowait()) for _ in range(client._messages.qsize())]
        assert kinds == [bytes, str]
        assert len(server._history.rows) == 2

    asyncio.run(check())


def test_a_port_in_use_is_reported(model, script):
    first = Server(describe_model(model, "swing.bg"), [], np.zeros((1, 20), np.float32))

    async def visit(session):
        second = Server(describe_model(model, "swing.bg"), [], np.zeros((1, 20), np.float32))
        with pytest.raises(BgError) as raised:
            await second.serve(first.port, lambda: None)
        assert raised.value.diagnostics[0].code == "BG008"

    asyncio.run(serving(first, visit))


# --- recorded runs ----------------------------------------------------------------------------


def test_an_archive_is_read_as_it_was_recorded(model, tmp_path):
    result = model.simulate()
    result.to_npz(tmp_path / "r.npz")
    found = read_recording(tmp_path / "r.npz")
    description = found.description
    assert description["observed"][0] == {
        "name": "angle [deg]", "unit": "deg", "factor": 1.0, "column": 0,
    }  # fmt: skip
    assert description["panels"][1] == {"quantities": [4], "across": 0}
    assert found.rows.shape == (31, 2 + description["width"])
    (sphere,) = (s for s in description["shapes"] if s["kind"] == "sphere")
    place = [2 + k for k in sphere["values"]["r"]["columns"]]
    np.testing.assert_allclose(found.rows[:, place], result.shapes[0].r, rtol=1e-6, atol=1e-7)
    result.to_csv(tmp_path / "r.csv")
    plain = read_recording(tmp_path / "r.csv")
    np.testing.assert_array_equal(plain.rows[:, 2:], found.rows[:, 2:7])


@pytest.mark.parametrize(
    ("name", "content"),
    [("a.npz", b"PK"), ("a.csv", b"x,y\n1,2\n"), ("a.csv", b"time,y\n1\n"), ("a.csv", b"time,y\n"),
     ("a.csv", b"\xff\xfe\n"), ("b.npz", None)],
)  # fmt: skip
def test_other_files_are_no_recordings(name, content, tmp_path):
    if content is None:
        np.savez(tmp_path / name, weights=np.zeros(3))
    else:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(BgError) as raised:
        read_recording(tmp_path / name)
    assert raised.value.diagnostics[0].code == "BG009"


def test_meshes_are_only_those_of_the_scene(tmp_path):
    (tmp_path / "hull.stl").write_bytes(b"solid")
    files = ("hull.stl", "../../etc/passwd", "gone.glb", "", "hull.stl")
    shapes = [{"file": file} for file in files]
    assert meshes_of({"shapes": shapes}, tmp_path) == [tmp_path / "hull.stl"]
    assert [s.get("mesh") for s in shapes] == [0, None, None, None, 0]
    assert shapes[2]["missing"]


# --- the command ------------------------------------------------------------------------------


def test_a_replay_is_one_file_with_all_rows(file, tmp_path, monkeypatch):
    monkeypatch.setattr("bgc.runtime.cli.view.bundle", lambda: "start('</script>')")
    target = tmp_path / "swing.html"
    done = CliRunner().invoke(application, ["view", str(file), "--export", str(target)])
    assert done.exit_code == 0 and "31 rows" in done.output, done.output
    text = target.read_text("utf-8")
    assert text.count("</script>") == 2 and "http" not in text.replace("http://www.w3.org", "")
    held = json.loads(text.split('id="replay">')[1].split("</script>")[0])
    width = 2 + held["description"]["width"]
    columns = np.frombuffer(zlib.decompress(b64decode(held["data"])), "<f4").reshape(width, -1)
    np.testing.assert_allclose(columns[0], np.linspace(0, 3, 31), rtol=1e-6)
    refused = CliRunner().invoke(application, ["view", str(file), "--export", "swing.pdf"])
    assert refused.exit_code == 1 and "BG070" in refused.output


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX limits")
def test_a_full_disk_keeps_the_earlier_replay(file, tmp_path, monkeypatch):
    import resource

    monkeypatch.setattr("bgc.runtime.cli.view.bundle", lambda: "x" * 100_000)
    target = tmp_path / "swing.html"
    target.write_text("earlier")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, before[1]))
    try:
        done = CliRunner().invoke(application, ["view", str(file), "--export", str(target)])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert done.exit_code == 1 and "BG055" in done.output, done.output
    assert target.read_text() == "earlier" and list(tmp_path.iterdir()) == [target]


def test_what_is_missing_is_named(file, monkeypatch):
    monkeypatch.setattr(pages, "_BUNDLE", Path("/nowhere/view.js"))
    done = CliRunner().invoke(application, ["view", str(file)])
    assert done.exit_code == 1 and "BG007" in done.output and "bgc_build.py" in done.output
    monkeypatch.setattr("bgc.runtime.cli.view.bundle", lambda: "")
    monkeypatch.setitem(sys.modules, "aiohttp", None)
    done = CliRunner().invoke(application, ["view", str(file)])
    assert done.exit_code == 1 and "BG058" in done.output and "`view`" in done.output


@pytest.mark.skipif(not hasattr(time, "pthread_getcpuclockid"), reason="POSIX signals")
def test_ctrl_c_ends_the_command_at_once(file, monkeypatch):
    program = (
        # Shells ignore SIGINT in background jobs.
        "import signal; signal.signal(2, signal.default_int_handler)\n"
        "import bgc.runtime.cli.view as v, bgc.runtime.view.server as s\n"
        "v.bundle = s.bundle = lambda: ''\n"
        "from bgc.runtime.cli import main; main()\n"
    )
    command = [sys.executable, "-c", program, "view", str(file), "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as p:
        assert p.stdout.readline().startswith("http://127.0.0.1:")
        p.send_signal(2)
        assert p.wait(10) == 130
        assert "Traceback" not in p.stderr.read()


def test_a_device_of_the_command_moves_the_model(tmp_path, monkeypatch):
    monkeypatch.setattr("bgc.runtime.cli.view.bundle", lambda: "")
    (tmp_path / "d.bg").write_text(
        """model M { input u[3] : m; state x : m = 0 m; der(x) = u[1]/(1 s); }
        scene s of M { device hand = trace(file = "a.csv"); drive u = hand.position; observe x;
        step 10 ms; run 1 s every 0.5 s; }""",
        "utf-8",
    )
    for name, x in (("a", 1), ("b", 3)):
        (tmp_path / f"{name}.csv").write_text(f"time,x,y,z\n0,{x},0,0\n9,{x},0,0\n")
    looped = bgc.compile(tmp_path / "d.bg", shapes=True)
    for devices, end in (({}, 1), ({"hand": str(tmp_path / "b.csv")}, 3)):
        run = LiveRun(looped, method_of(looped)[0], {}, read_choices(devices))
        run.reset()
        (row,), _ = run.advance(np.array([1.0]))
        run.close()
        assert row[0] == pytest.approx(end)
    target = tmp_path / "d.html"
    command = ["view", str(tmp_path / "d.bg"), "--device", f"hand={tmp_path / 'b.csv'}"]
    done = CliRunner().invoke(application, [*command, "--export", str(target)])
    assert done.exit_code == 0, done.output
    held = json.loads(target.read_text("utf-8").split('id="replay">')[1].split("</script>")[0])
    rows = np.frombuffer(zlib.decompress(b64decode(held["data"])), "<f4").reshape(3, -1)
    assert rows[2, -1] == pytest.approx(3)
