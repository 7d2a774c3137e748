"""Devices that a page takes in its hand: poses, drivers, messages; without a browser."""

import asyncio
import re

import numpy as np
import pytest
from model_files import model_text
from refusals import refusal
from view_server import address, home, serving

import bgc
from bgc.building.build import runtime_directory
from bgc.language.scene_tables import DEVICE_INPUTS
from bgc.runtime.running.device_drivers import DeviceChoice, read_choices
from bgc.runtime.running.simulate import method_of
from bgc.runtime.view.hands import _CHANNELS, Hands
from bgc.runtime.view.live import LiveRun
from bgc.runtime.view.player import Player
from bgc.runtime.view.protocol import read_command
from bgc.runtime.view.scene_description import describe_model
from bgc.runtime.view.server import Server

MODEL = model_text("view_hands")


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    folder = tmp_path_factory.mktemp("hands")
    (folder / "motion.csv").write_text("time,x,y,z\n0,1,0,0\n9,1,0,0\n")
    (folder / "reach.bg").write_text(MODEL, "utf-8")
    return bgc.compile(folder / "reach.bg", shapes=True, preview=True)


@pytest.fixture
def run(model):
    live = LiveRun(model, method_of(model)[0], {})
    live.reset()
    yield live
    live.close()


def test_the_page_takes_a_device_and_gives_it_back(run):
    (row,), _ = run.advance(np.array([1.0]))
    assert row[0] == pytest.approx(1)  # the trace
    pose = {"position": [-2, 0, 0.5], "buttons": [0, 1], "orientation": [0.2, 0, 0, 0.2]}
    run.hand("one", pose)
    (row,), _ = run.advance(np.array([2.0]))
    assert row[:3] == pytest.approx([-1, 0, 0.5], abs=0.031)
    assert row[3] == 1 and row[4] == pytest.approx(np.pi / 2)  # of length 1
    assert run.hands.held == ["one"]
    run.leave("one")
    (row,), _ = run.advance(np.array([3.0]))
    assert row[0] == pytest.approx(0, abs=0.031) and run.hands.held == []
    run.hand("one", {"position": [5, 0, 0]})
    run.reset()  # the scene from its start, with its own drivers
    (row,), _ = run.advance(np.array([1.0]))
    assert row[0] == pytest.approx(1) and run.hands.held == []


def test_a_page_that_goes_while_it_holds_a_device_lets_go(run, model, monkeypatch):
    monkeypatch.setattr("bgc.runtime.view.server.bundle", lambda: "")
    server = Server(describe_model(model, "reach.bg"), [])
    commands = []
    player = Player(run, server.publish)
    monkeypatch.setattr(player, "command", commands.append)
    server.attach(player)

    async def visit(session):
        pages = [
            await session.ws_connect(address(server, "/ws"), headers=home(server)) for _ in "ab"
        ]
        pose = {"type": "hand", "device": "one", "position": [-2, 0, 0]}
        for page in pages:
            await page.send_json(pose)
        await asyncio.sleep(0.1)
        await pages[0].close()  # the other one has taken it since
        pages[1]._response.connection.transport.abort()
        while server._clients:
            await asyncio.sleep(0.01)
        assert commands == [pose, pose, {"type": "let_go", "device": "one"}]

    asyncio.run(serving(server, visit))
    player._ready = True
    run.hand("one", {"position": [-2, 0, 0]})
    player._on_let_go({"type": "let_go", "device": "one"})
    (row,), _ = run.advance(np.array([1.0]))
    assert abs(row[0]) < 0.05  # the middle, neither the hand's nor the trace's 1 m/s
    run.leave("one")
    player._on_let_go({"type": "let_go", "device": "one"})
    assert run.hands.held == []  # somebody else has given it back


def test_a_device_of_a_real_hand_is_not_taken(run, model):
    run.hands = Hands(model, {"two": DeviceChoice("udp", "port=5005\n")})
    for name, words in (("two", "--device two=pointer"), ("three", "`one`, `two`")):
        found = refusal(run.hand, name, {"position": [0, 0, 0]})
        assert found.code == "BG756" and words in f"{found.message} {found.help}"
    events = []
    player = Player(run, lambda *event: events.append(event))
    player.start(run.reset())
    player.command({"type": "hand", "device": "three", "position": [0.0, 0.0, 0.0]})
    player.command({"type": "hand", "device": "one", "position": [3.0, 0.0, 0.0]})
    player.command({"type": "step"})
    player.close()
    faults = [content for kind, content in events if kind == "fault"]
    assert [f["messages"][0]["code"] for f in faults] == ["BG756"] and not faults[0]["stopped"]
    assert [c["held"] for kind, c in events if kind == "state"][-1] == ["one"]


def test_a_description_says_which_device_moves_which_handle(model):
    found = describe_model(model, "reach.bg", read_choices({"two": "pointer"}))
    one, two = found["devices"]
    assert (one["driver"], one["free"], one["reach"]) == ("trace", True, 0.06)
    assert one["reads"] == ["position", "orientation", "buttons"]
    assert (two["driver"], two["reach"], two["reads"]) == ("pointer", 0.06, ["position"])
    assert describe_model(model, "")["devices"][1]["reach"] == 0.08
    moved = {shape["name"]: (shape.get("device"), shape.get("axes")) for shape in found["shapes"]}
    assert moved == {"handle": ("two", [0, 1, 2]), "handle[2]": ("one", [0, 2])}
    beside, placed = (shape["values"] for shape in found["shapes"])
    assert set(beside) == {"position"} and set(placed) == {"position", "force", "aim", "r", "A"}


def test_every_channel_that_a_model_may_read_has_its_name():
    header = (runtime_directory() / "bgc.h").read_text("utf-8")
    numbers = {
        name.lower(): int(k) for name, k in re.findall(r"BGC_(\w+) = (\d+),? +/\* in,", header)
    }
    assert set(numbers) == set(DEVICE_INPUTS)
    assert {number: name for name, number in numbers.items()} == _CHANNELS


@pytest.mark.parametrize(
    "pose",
    [
        '"position": [0, 0]', '"position": [0, 0, 1e9]', '"position": [0, 0, NaN]', '"position": 1',
        '"position": [0, 0, true]', '"position": [0, 0, 0], "orientation": [0, 0, 0, 0]',
        '"position": [0, 0, 0], "orientation": [1e-320, 0, 0, 0]',
        '"position": [0, 0, 0], "buttons": [1, 1, 1, 1, 1, 1, 1, 1, 1]', '"buttons": [1]',
        '"position": [0, 0, 0], "gripper": "wide"', '"position": [0, 0, 0], "device": 1',
    ],
)  # fmt: skip
def test_a_pose_that_is_none_is_ignored(pose):
    assert read_command('{"type": "hand", "device": "one", "position": [0, 0, 0]}') is not None
    assert read_command(f'{{"type": "hand", "device": "one", {pose}}}') is None
    assert read_command('{"type": "leave"}') is None
