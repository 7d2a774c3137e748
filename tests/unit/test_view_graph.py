"""The bond graph of the page, its meters, and parts exchanged beside a run; without a browser."""

import asyncio
import itertools
import json
import threading
import time
from pathlib import Path

import aiohttp
import numpy as np
import pytest
from model_files import model_file
from view_server import address, home, serving

import bgc
from bgc.diagnostics.catalogue.machine import dot_missing
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.options import Options
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.model_loading import load_or_compile
from bgc.runtime.running.simulate import method_of
from bgc.runtime.view import graph_page as graphs
from bgc.runtime.view.aside import Answer, Aside, Request
from bgc.runtime.view.layout import layered
from bgc.runtime.view.live import LiveRun
from bgc.runtime.view.meter import Meter
from bgc.runtime.view.part_exchange import Exchange, Prepared
from bgc.runtime.view.player import Player
from bgc.runtime.view.protocol import read_command
from bgc.runtime.view.scene_description import describe_model
from bgc.runtime.view.server import Server

FILE = model_file("view_graph")


@pytest.fixture(scope="module")
def found():
    return graphs.graph_of_scene(FILE, Options())


@pytest.fixture(scope="module")
def model():
    return bgc.compile(FILE, shapes=True, preview=True)


def test_a_graph_has_strokes_reasons_lines_and_slots(found):
    graph = found.description
    names = [bond["name"] for bond in graph["bonds"]]
    supply = graph["bonds"][names.index("supply -> loop")]
    assert (supply["stroke"], supply["rule"], supply["units"]) == ("head", "fixed", ["V", "A"])
    assert "supply" in supply["reason"] and supply["power"]
    assert supply["line"]["text"] == "supply -> loop -> wire;"
    assert graph["parts"]["load"]["model"] == "Heater"
    assert graph["parts"]["load"]["line"] == {
        "file": FILE.name, "number": 18, "text": "load   : Load = Heater;"
    }  # fmt: skip
    assert graph["elements"]["store"]["kind"] == "C"
    assert graph["slots"] == [
        {"slot": "load", "interface": "Load", "filled": "Heater", "others": ["Coil"]}
    ]
    whole = graph["layouts"][-1]
    assert [layout["depth"] for layout in graph["layouts"]] == [1]
    drawn = {node["path"] for node in whole["nodes"]}
    assert drawn == {"supply", "loop", "wire", "store", "load.r"}
    assert sorted(b for edge in whole["edges"] for b in edge["bonds"]) == list(range(len(names)))


def test_without_graphviz_a_layout_of_its_own(found, monkeypatch):
    def missing(text, kind):
        raise BgError([dot_missing()])

    monkeypatch.setattr(graphs, "lay_out", missing)
    causal = compile_scene(FILE, Options(), until="causality").causal
    (alone,) = graphs.describe_graph(causal)["layouts"]
    (drawn,) = found.description["layouts"]
    assert [n["path"] for n in alone["nodes"]] == [n["path"] for n in drawn["nodes"]]
    for layout in (alone, drawn):
        boxes = [(*n["at"], *n["size"]) for n in layout["nodes"]]
        for (x, y, w, h), (u, v, a, b) in itertools.combinations(boxes, 2):
            assert abs(x - u) >= (w + a) / 2 or abs(y - v) >= (h + b) / 2
        for edge in layout["edges"]:
            points = np.reshape(edge["curve"], (-1, 2))
            assert len(points) % 3 == 1
            for end, node in ((points[0], "tail"), (points[-1], "head")):
                x, y, w, h = boxes[edge[node]]
                assert abs(end[0] - x) < w / 2 + 9 and abs(end[1] - y) < h / 2 + 9


def test_layers_follow_the_arrows_and_long_edges_pass_between():
    sizes = [(20.0, 10.0)] * 6
    edges = [(0, 1), (1, 2), (2, 3), (0, 3), (3, 1), (4, 3), (5, 5)]
    at, curves = layered(sizes, edges)
    xs = [x for x, _ in at]
    assert xs[0] < xs[1] < xs[2] < xs[3] and xs[4] == xs[2]  # (3, 1) closes a circle
    assert curves[6] == [] and len(curves[3]) == 10
    assert curves[4][0][0] > curves[4][-1][0]  # from its tail to its head
    for x, y in curves[3][3:7:3]:  # the long edge avoids nodes 1 and 2
        assert all(abs(y - at[n][1]) >= 5 for n in (1, 2) if x == at[n][0])
    assert layered([], []) == ([], [])


def test_meters_read_the_power_of_each_bond(found, model):
    names = [bond["name"] for bond in found.description["bonds"]]
    meter = Meter(found.built, model)
    run = LiveRun(model, method_of(model)[0], {})
    run.reset()
    for now, volts in ((5e-3, 10.0), (8e-3, 40.0)):
        run.set_parameter("volts", volts)
        (row,), _ = run.advance(np.array([now]))
        readings = meter.read(*run.snapshot(), run.time, run.given).reshape(-1, 2)
        power = dict(zip(names, readings.prod(axis=1), strict=True))
        current = (volts - row[0]) / 7.0
        assert row[1] == pytest.approx(current, rel=1e-6)
        assert power["supply -> loop"] == pytest.approx(volts * current, rel=1e-5)
        assert power["loop -> wire"] == pytest.approx(2 * current**2, rel=1e-5)
        assert power["loop -> store"] == pytest.approx(row[0] * current, rel=1e-5)
    run.close()
    assert meter.absent == [] and meter.width == 2 * len(names)


class Seen:
    """The events of a player."""

    def __init__(self):
        self.events, self.news = [], threading.Condition()

    def __call__(self, kind, content):
        with self.news:
            self.events.append((kind, content))
            self.news.notify_all()

    def wait(self, kind, number=1, seconds=60.0):
        """The content of event number `number` of a kind."""

        def those():
            return [content for each, content in self.events if each == kind]

        with self.news:
            assert self.news.wait_for(lambda: len(those()) >= number, seconds), self.events[-3:]
            return those()[number - 1]


@pytest.fixture
def script(monkeypatch):
    monkeypatch.setattr("bgc.runtime.view.server.bundle", lambda: "")


@pytest.fixture
def played(model):
    def prepare(other: LoadedModel) -> Prepared:
        run = LiveRun(other, method_of(other)[0], {})
        return Prepared(run, describe_model(other, FILE.name), [])

    seen = Seen()
    prepared = prepare(model)
    exchange = Exchange(FILE, Options(shapes=True), prepare)
    player = Player(prepared.run, seen, exchange=exchange)
    player.start(prepared.run.reset())
    yield player, seen
    player.close()


def test_a_part_that_is_refused_leaves_the_run_as_it_is(played, found, monkeypatch):
    player, seen = played
    player.command({"type": "play"})
    player.command({"type": "use", "slot": "load", "part": "Nothing"})
    fault = seen.wait("fault")
    assert not fault["stopped"] and "Nothing" in fault["messages"][0]["text"]
    assert all("excerpt" in message for message in fault["messages"])
    assert player.playing and player.state["busy"] == "" and player.epoch == 0
    player.command({"type": "built_graph", "answer": Answer(found)})
    player.command({"type": "watch", "value": True})
    graph = seen.wait("graph")
    epoch, row = seen.wait("powers", 2)
    assert epoch == 0 and row.shape == (1, 2 + 2 * len(graph["bonds"])) and np.isfinite(row).all()
    # The meters have the values that a start at rest has found.
    assert row[0, 2] == pytest.approx(10)
    monkeypatch.setattr(LiveRun, "varied", {"volts": 40.0})
    with seen.news:
        seen.events.clear()
    assert seen.wait("powers", 2)[1][0, 2] == pytest.approx(40)


def test_a_graph_of_edited_files_is_not_that_of_the_run(played, found, monkeypatch):
    player, seen = played
    monkeypatch.setattr(Meter, "source", "that of another text")
    player.command({"type": "built_graph", "answer": Answer(found)})
    fault = seen.wait("fault")
    assert fault["messages"][0]["code"] == "BG758" and not fault["stopped"]
    assert player.state["busy"] == "" and player._graph is None


def test_a_page_that_is_killed_while_a_part_is_exchanged_leaves_the_run(model, script):
    """The model arrives at the pages that are left, and at those that come later."""
    waiting = []

    def prepare(other: LoadedModel) -> Prepared:
        run = LiveRun(other, method_of(other)[0], {})
        return Prepared(run, describe_model(other, FILE.name), [])

    prepared = prepare(model)
    server = Server(prepared.description, [])
    exchange = Exchange(FILE, Options(shapes=True), prepare)
    exchange._aside.ask = lambda request, done: waiting.append(done)
    player = Player(prepared.run, server.publish, exchange=exchange)
    server.attach(player)
    first = prepared.run.reset()

    async def visit(session):
        player.start(first)
        killed = await session.ws_connect(address(server, "/ws"), headers=home(server))
        stays = await session.ws_connect(address(server, "/ws"), headers=home(server))
        await killed.send_json({"type": "set", "name": "volts", "value": 20})
        await killed.send_json({"type": "play"})
        await killed.send_json({"type": "use", "slot": "load", "part": "Coil"})
        while not waiting:
            await asyncio.sleep(0.01)
        killed._response.connection.transport.abort()  # no closing message
        while len(server._clients) > 1:
            await asyncio.sleep(0.01)
        waiting[0](Answer(load_or_compile(FILE, Options(shapes=True, preview=True))))
        later = await session.ws_connect(address(server, "/ws"), headers=home(server))
        for client in (stays, later):
            state, models = {}, []
            while state.get("epoch") != 1:
                message = await client.receive(timeout=10)
                if message.type is aiohttp.WSMsgType.TEXT:
                    content = json.loads(message.data)
                    state = content if content["type"] == "state" else state
                    models += [content["model"]] if content["type"] == "scene" else []
            assert state["playing"] and state["busy"] == ""
            assert models[-1] == 1  # the number of exchanges: the description is the same
        assert player._run.given == {"volts": 20}

    try:
        asyncio.run(serving(server, visit))
    finally:
        player.close()


def test_a_compilation_that_is_killed_is_reported(played, monkeypatch):
    player, seen = played
    monkeypatch.setattr("bgc.runtime.view.aside._PROGRAM", "import os; os._exit(3)")
    player.command({"type": "graph"})
    assert seen.wait("fault")["messages"][0]["code"] == "BG754"


def test_a_new_request_ends_the_one_before(monkeypatch):
    monkeypatch.setattr("bgc.runtime.view.aside._PROGRAM", "import time; time.sleep(60)")
    answers = []
    aside = Aside()
    start = time.monotonic()
    for _ in range(2):
        aside.ask(Request("model", Path("a.bg"), Options()), answers.append)
    aside.end()
    assert answers == [] and time.monotonic() - start < 30


@pytest.mark.parametrize(
    "content",
    ['"use", "slot": "a"', '"use", "slot": "a", "part": "B; run 1 s"', '"watch", "value": 1'],
)
def test_other_requests_are_ignored(content):
    assert read_command('{"type": "use", "slot": "a.b[1]", "part": "Rigid[5]"}') is not None
    assert read_command(f'{{"type": {content}}}') is None
