"""The page of a loop in real time, without a browser: what it shows, and what it hands over."""

import time

import numpy as np
import pytest
from model_files import model_text

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.realtime.loop_options import RealtimeOptions
from bgc.runtime.running.device_drivers import read_choices
from bgc.runtime.view import aside
from bgc.runtime.view.loop_view import LoopFollower

MODEL = model_text("view_loop")


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    folder = tmp_path_factory.mktemp("loop")
    (folder / "pushed.bg").write_text(MODEL, "utf-8")
    return bgc.compile(folder / "pushed.bg", shapes=True)


class Page:
    """A loop with a pointer, and the events that its pages would get."""

    def __init__(self, model, **arguments):
        self.events, choices = [], {"hand": "pointer(reach = 5 cm)"}
        self.follower = LoopFollower("pushed.bg", read_choices(choices))
        options = RealtimeOptions(priority=False, watchdog=0.0, policy="hold", ramp=0.02)
        self.loop = model.realtime(
            devices=choices, options=options, on_records=self.follower.take, **arguments
        )
        self.follower.follow(self.loop, lambda *event: self.events.append(event))

    def of(self, wanted):
        return [content for kind, content in self.events if kind == wanted]

    def until(self, holds):
        end = time.monotonic() + 20.0
        while not (found := holds()):
            assert time.monotonic() < end, [event for event in self.events if event[0] != "rows"]
            time.sleep(0.002)
        return found

    def row(self):
        return self.of("rows")[-1][1][-1, 2:] if self.of("rows") else np.zeros(3)

    def command(self, kind, **content):
        self.follower.command({"type": kind, **content})


@pytest.fixture
def page(model):
    page = Page(model)
    with page.loop:
        yield page


def test_a_page_shows_a_loop_and_gives_the_pose_of_its_pointer(page):
    found, _ = page.follower.describe(page.loop.course.model)
    (hand,) = found["devices"]
    assert (found["realtime"], hand["free"], hand["reach"]) == (True, True, 0.05)
    page.command("hand", device="hand", position=[0.03, 0, 0], orientation=[0, 0, 0, 2])
    page.until(lambda: page.row()[0] == np.float32(0.03))
    assert page.row()[1] == np.float32(0.03) and page.follower.state["held"] == ["hand"]
    # A page that goes leaves the hand in the middle.
    page.command("let_go", device="hand")
    page.until(lambda: page.row()[0] == 0.0 and page.row()[2] > 0.0)
    assert page.follower.state["held"] == []
    # What means nothing to a loop changes nothing; a device that is none is refused.
    for kind in ("play", "pause", "step"):
        page.command(kind)
    page.command("hand", device="stick", position=[0, 0, 0])
    (fault,) = page.of("fault")
    assert fault["messages"][0]["code"] == "BG777" and not fault["stopped"]
    assert (
        fault["messages"][0]["text"]
        == "`stick` cannot take this pose: it is no pointer, as hand is"
    )
    state = page.until(lambda: [s for s in page.of("state") if s["playing"]])[-1]
    assert state["loop"]["words"].startswith("real time")
    assert any("deadlines missed" in line for line in state["loop"]["lines"])
    times = np.array([rows[0, 0] for _, rows in page.of("rows")])
    assert (np.diff(times) > 0).all() and (page.follower.epoch == 0)


def test_values_and_parts_hold_from_an_exchange_on(page, monkeypatch):
    monkeypatch.setattr(aside.Aside, "ask", lambda self, asked, done: done(aside._answer(asked)))
    page.command("set", name="gain", value=10.0)
    fault = page.until(lambda: page.of("fault"))[-1]
    assert fault["messages"][0]["code"] == "BG061"
    page.command("set", name="gain", value=4.0)
    page.until(lambda: page.of("values")[-1][0] == 4.0)
    page.command("hand", device="hand", position=[0.01, 0, 0])
    page.until(lambda: page.row()[0] == np.float32(0.01))
    assert page.row()[1] == np.float32(0.01)  # the model that runs has the earlier value
    page.command("reset")
    page.until(lambda: page.row()[1] == np.float32(0.04) and page.follower.epoch == 1)
    assert not page.of("scene")  # the same page
    page.command("graph")
    graph = page.until(lambda: page.of("graph"))[-1]
    assert {"Light", "Heavy"} == {graph["slots"][0]["filled"], *graph["slots"][0]["others"]}
    page.command("use", slot="load", part="Nothing")
    page.until(lambda: len(page.of("fault")) == 2)
    page.command("use", slot="load", part="Heavy")
    page.until(lambda: page.of("scene"))  # another page
    page.until(lambda: page.follower.epoch == 2 and page.row()[2] > 1e-3)
    assert page.row()[1] == np.float32(0.04)  # with the values that were set
    assert page.loop.report.exchanges == 2 and len(page.of("fault")) == 2
    rows = np.array([rows[-1] for epoch, rows in page.of("rows") if epoch == 2])
    late = rows[-1]
    assert late[4] == pytest.approx(0.04 / 2 * (late[0] - rows[0, 0]) + rows[0, 4], rel=1e-3)


def test_a_page_is_told_why_its_loop_has_ended(model):
    page = Page(model, parameters={"most": 1e-3})
    with page.loop:
        page.command("hand", device="hand", position=[0.05, 0, 0])
        page.until(lambda: not page.loop.report.is_running)
        report = page.loop.close()
        page.command("hand", device="hand", position=[0.01, 0, 0])  # comes too late
        page.command("reset")
        page.until(lambda: page.of("fault"))
    page.follower.end(report)
    fault = page.of("fault")[-1]
    assert fault["stopped"] and fault["messages"][0]["code"] == "BG705"
    assert page.of("state")[-1]["ended"] and page.of("state")[-1]["playing"] is False
    assert page.of("fault")[0]["messages"][0]["code"] == "BG757"
    with pytest.raises(BgError):
        page.loop.exchange(model)
