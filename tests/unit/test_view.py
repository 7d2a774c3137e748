"""Live runs, their player and its messages."""

import json
import re
import struct
import threading
import time

import numpy as np
import pytest
from refusals import codes_of
from swing import begin_run, compile_swing, write_swing

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.language.solver import Solver
from bgc.runtime.results.result import Result
from bgc.runtime.running.simulate import method_of
from bgc.runtime.view.history import History, as_rows
from bgc.runtime.view.live import LiveRun
from bgc.runtime.view.player import FRAME, Player, usual_speed
from bgc.runtime.view.protocol import HEADER, pack_rows, read_command
from bgc.runtime.view.scene_description import describe_model, describe_result, panels_of


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
    assert codes_of(run.set_parameter, "r", 5.0) == ["BG755"]
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
    fixed = LiveRun(model, method_of(model, Solver("rk4", step=1e-5))[0], {})
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


def test_a_recorded_run_has_the_errors_that_its_plots_show():
    time = np.linspace(0.0, 1.0, 11)
    columns = {"a": time, "b": time, "c": time, "d": time}
    errors = {"a": 0.1 * time, "b": 1e-6 * time, "c": np.full(11, np.nan)}
    result = Result("s", time, columns, dict.fromkeys(columns, "m"), "rodas5p", {}, errors=errors)
    description, rows = describe_result(result, "s.bg")
    assert [quantity.get("error", "hidden") for quantity in description["observed"]] == [
        4, "hidden", None, "hidden",
    ]  # fmt: skip
    assert description["width"] == 5 and rows[:, 4].tolist() == errors["a"].tolist()
