"""The server of the view without a browser, recorded runs, and the command."""

import asyncio
import json
import subprocess
import sys
import time
import zlib
from base64 import b64decode
from pathlib import Path

import aiohttp
import numpy as np
import pytest
from click.testing import CliRunner
from refusals import refusals
from swing import begin_run, compile_swing, write_swing
from view_server import address, home, serving

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.cli.app import application
from bgc.runtime.running.device_drivers import read_choices
from bgc.runtime.running.simulate import method_of
from bgc.runtime.view import page as pages
from bgc.runtime.view.live import LiveRun
from bgc.runtime.view.player import Player
from bgc.runtime.view.protocol import HEADER
from bgc.runtime.view.recording import read_recording
from bgc.runtime.view.scene_description import describe_model, meshes_of
from bgc.runtime.view.server import Client, Server


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return write_swing(tmp_path_factory.mktemp("view"))


@pytest.fixture(scope="module")
def model(file):
    return compile_swing(file)


@pytest.fixture
def run(model):
    run = begin_run(model)
    yield run
    run.close()


@pytest.fixture
def script(monkeypatch):
    """A page without its bundle, which these tests do without."""
    monkeypatch.setattr("bgc.runtime.view.server.bundle", lambda: "'</script>'")


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
    assert refusals(read_recording, tmp_path / name)[0].code == "BG009"


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
