"""`bgc reduce` on a wall whose layers and skin are finer than required."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import check_source
from bgc.options import Options
from bgc.runtime.cli.app import application
from bgc.runtime.reduce import method_choice
from bgc.runtime.reduce.ladders import Elaborations

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("measured")]

SECONDS = {"reduced": 1.0, "own": 20.0, "whole": 2.0, "second": 1.5}

WALL = """
interface Skin { port a in; port b out; }
/// A film that stores heat.
model Thick is Skin {
  port a in; port b out; param capacity = 1e-4 in 0 .. 10;
  film : J1; glue : R(0.1); node : J0; store : C(capacity);
  a -> film -> node -> b; film -> glue; node -> store;
}
model Thin is Skin {
  port a in; port b out; film : J1; glue : R(0.1);
  a -> film -> b; film -> glue;
}
model Double is Skin {
  port a in; port b out; one : Thick; two : Thick;
  a -> one -> two -> b;
}
model Wall[n = 8] {
  param capacity = 1e-4 in 0 .. 10;
  for i in 1..n {
    slab[i] : J1; wool[i] : R(1/n); node[i] : J0; brick[i] : C(1/n);
    slab[i] -> wool[i]; slab[i] -> node[i] -> brick[i];
  }
  for i in 2..n { node[i - 1] -> slab[i]; }
  warm : Se(e = 1);
  skin : Skin = Thick(capacity = capacity);
  warm -> skin -> slab[1];
  output inside = node[n].e;
}
scene wall of Wall { observe inside; require inside within 0.1; run 1 s every 20 ms; }
"""


@pytest.fixture(autouse=True)
def _given_times(monkeypatch):
    """Times that no other process disturbs: the reduced scene is the faster one."""
    monkeypatch.setattr(
        method_choice, "_in_turns", lambda session, runs: {name: SECONDS[name] for name in runs}
    )


def written(folder: Path, text: str = WALL) -> Path:
    path = folder / "wall.bg"
    path.write_text(text)
    return path


def tight(path: Path, **values: float) -> np.ndarray:
    """An independent solution: another method than those of references, at rtol 1e-11."""
    model = bgc.compile(path, parameters=values)
    return model.simulate(solver="dopri5", rtol=1e-11, every=1e-3, error=False)["inside"]


# --- coarser forms ----------------------------------------------------------------------------


def forms(text: str, folder: Path) -> dict[str, list[str]]:
    elaborations = Elaborations(written(folder, text), Options())
    return {
        ladder.part: ["".join(c.statement for c in form.changes) for form in ladder.forms]
        for ladder in elaborations.ladders(lambda: False).all
    }


def test_coarser_forms_are_smaller_dimensions_and_smaller_models(tmp_path):
    """`Double` fits the slot too, and has more variables."""
    assert forms(WALL, tmp_path) == {
        "n": ["set n = 1;", "set n = 2;", "set n = 4;"],
        "skin": ["use skin = Thin;"],
    }


ROW = WALL.replace(
    "warm : Se(e = 1);",
    "warm : Se(e = 1); for i in 1..2 { coat[i] : Skin = Thick; air[i] : Se(e = 0);"
    " node[n] -> coat[i] -> air[i]; }",
)


def test_parts_of_an_array_change_together(tmp_path):
    assert forms(ROW, tmp_path)["coat[*]"] == ["use coat[*] = Thin;"]
    elaborations = Elaborations(tmp_path / "wall.bg", Options())
    (ladder,) = (e for e in elaborations.ladders(lambda: False).all if e.part == "coat[*]")
    found = elaborations.expanded(ladder.forms[0].changes)
    assert [change.statement for change in found] == [
        "use coat[1] = Thin;",
        "use coat[2] = Thin;",
    ]


# --- the search -------------------------------------------------------------------------------


def test_the_reduced_scene_is_as_accurate_as_its_proof_says(tmp_path):
    path = written(tmp_path)
    found = bgc.reduce(path)
    assert found.proof is not None and not found.ended
    assert (found.best.states, found.whole.states) == (4, 9)
    assert found.best.work < 0.6 * found.whole.work
    out = tmp_path / "reduced.bg"
    found.to_bg(out)
    assert not check_source(out)
    reduced = bgc.compile(out).simulate(every=1e-3, error=False)
    off = np.max(np.abs(reduced["inside"] - tight(path)))
    assert off <= 0.1
    # Instants of comparison are other ones than these rows.
    assert off / 0.1 == pytest.approx(found.proof.error, rel=0.05)
    assert found.proof.off == pytest.approx(0.1 * found.proof.error, rel=1e-2)


def test_every_trial_states_its_true_error(tmp_path):
    path = written(tmp_path)
    found = bgc.reduce(path)
    exact = tight(path)
    for trial in found.tried:
        uses = {c.name: c.value for c in trial.changes if c.is_use}
        sets = {c.name: float(c.value) for c in trial.changes if not c.is_use}
        model = bgc.compile(path, uses=uses, parameters=sets)
        rows = model.simulate(solver="radau5", rtol=1e-8, every=1e-3, error=False)["inside"]
        true = np.max(np.abs(rows - exact)) / 0.1
        assert trial.error == pytest.approx(true, rel=0.05, abs=0.06)


def test_a_whole_scene_that_is_faster_is_the_one_that_is_found(tmp_path, monkeypatch):
    monkeypatch.setattr(method_choice, "_in_turns", lambda session, runs: SECONDS | {"whole": 0.9})
    path, out = written(tmp_path), tmp_path / "reduced.bg"
    found = bgc.reduce(path)
    assert (found.best.states, found.coarsest.states) == (9, 4)
    assert found.sentence.startswith("Nothing is gained by dropping: the whole scene is as fast as")
    found.to_bg(out)
    assert "set n" not in out.read_text() and "use skin" not in out.read_text()
    rows = bgc.compile(out).simulate(every=1e-3, error=False)["inside"]
    off = np.max(np.abs(rows - tight(path)))
    assert off / 0.1 == pytest.approx(found.proof.error, rel=0.05, abs=2e-3)
    assert found.proof.method in out.read_text()


def test_a_change_has_to_hold_in_all_cases(tmp_path):
    """A film of capacity 3 may not be left out."""
    path = written(tmp_path)
    alone = bgc.reduce(path)
    found = bgc.reduce(path, over=["capacity=1e-4, 3"])
    assert "use skin = Thin;" in [c.statement for c in alone.best.changes]
    assert "use skin = Thin;" not in [c.statement for c in found.best.changes]
    assert found.proof is not None and len(found.cases) == 2
    out = tmp_path / "reduced.bg"
    found.to_bg(out)
    for capacity in (1e-4, 3.0):
        model = bgc.compile(out, parameters={"capacity": float(capacity)})
        rows = model.simulate(every=1e-3, error=False)["inside"]
        assert np.max(np.abs(rows - tight(path, capacity=capacity))) <= 0.1


def test_where_nothing_can_be_left_out_it_says_so(tmp_path):
    path = written(tmp_path)
    found = bgc.reduce(path, within={"inside": 1e-7})
    assert found.proof is None and found.reduced is None and not found.text
    assert found.sentence.startswith("Nothing can be left out: none of 4 coarser forms")
    with pytest.raises(ValueError, match="Nothing can be left out"):
        found.to_bg(tmp_path / "none.bg")
    plain = (
        "model A { c : C(1); r : R(1); j : J1; j -> c, r; } scene s of A { observe c.q; run 1 s; }"
    )
    found = bgc.reduce(written(tmp_path, plain), within={"c.q": 0.1})
    assert found.sentence == "Nothing can be left out: no part of the scene has a coarser form."


def test_a_spent_budget_claims_nothing_and_is_continued(tmp_path):
    path = written(tmp_path)
    found = bgc.reduce(path, budget=1e-3)
    assert found.ended and found.proof is None
    assert "The budget was spent" in found.sentence
    found = bgc.reduce(path)
    again = bgc.reduce(path)
    assert again.tried == found.tried
    assert again.best == found.best


def test_without_a_requirement_nothing_is_reduced(tmp_path):
    path = written(tmp_path, WALL.replace("require inside within 0.1;", ""))
    with pytest.raises(BgError) as caught:
        bgc.reduce(path)
    assert caught.value.diagnostics[0].code == "BG661"


# --- where it holds ---------------------------------------------------------------------------


def test_the_reduced_scene_holds_up_to_its_limits(tmp_path):
    """A film of a larger capacity may not be left out."""
    path, out = written(tmp_path), tmp_path / "reduced.bg"
    found = bgc.reduce(path, parameters={"capacity": 0.2})
    (valid,) = (each for each in found.valid if each.name == "capacity")
    assert valid.below.fails is None and valid.below.holds == pytest.approx(0.02)
    assert valid.above.fails is not None and valid.above.holds is not None
    found.to_bg(out)
    assert "set capacity = 0.2;" in out.read_text()
    assert f"capacity = {valid.above.fails:g}" in " ".join(out.read_text().split())
    for value, holds in ((valid.above.holds, True), (valid.above.fails, False)):
        rows = bgc.compile(out).simulate(every=1e-3, error=False)["inside"]
        off = np.max(np.abs(rows - tight(path, capacity=value)))
        assert bool(off <= 0.1) is holds
    assert off / 0.1 == pytest.approx(valid.above.error, rel=0.1)


# --- the command and the proof ----------------------------------------------------------------


def test_the_command_writes_the_scene_the_table_and_the_plot(tmp_path):
    path = written(tmp_path)
    out, table, plot = (tmp_path / name for name in ("r.bg", "r.csv", "r.svg"))
    page = tmp_path / "r.html"
    words = ["reduce", str(path), "-o", str(out), "--table", str(table), "--plot", str(plot)]
    words += ["--html", str(page)]
    result = CliRunner().invoke(application, [*words, "--within", "inside: 0.12"])
    assert result.exit_code == 0, result.output
    assert "states are enough" in result.stdout
    assert 'import "wall.bg";' in out.read_text()
    assert "scene wall_reduced is wall {" in out.read_text()
    assert "set n = 8" not in out.read_text()
    assert table.read_text().startswith("changes,status,states,operations,error,")
    assert plot.read_text().startswith("<?xml")
    assert "scene wall_reduced is wall {" in page.read_text()
    assert "Where the reduced scene stops being valid" in page.read_text()
    result = CliRunner().invoke(application, [*words, "--within", "inside: 0.12", "--json"])
    value = json.loads(result.stdout)
    assert value["states"] < value["of_states"] and value["error"] <= 1
    result = CliRunner().invoke(
        application, ["reduce", str(path), "--within", "inside: 0.12", "-q"]
    )
    assert "scene wall_reduced is wall {" in result.stdout


PROVED = 'scene quick is wall {{ set n = 4; proof "{}"; }}'


def test_a_change_of_the_original_is_noticed(tmp_path):
    found = bgc.reduce(written(tmp_path))
    assert found.reduced is not None
    text = WALL + PROVED.format(found.reduced.digest)

    def codes(changed: str) -> list[str]:
        return [d.code for d in check_source(written(tmp_path, changed))]

    assert codes(text) == []
    assert codes(text.replace("/// A film", "/// Another film").replace("; ", ";\n")) == []
    assert codes(text + "model Other { r : R(1); s : Se(1); s -> r; }") == []
    assert codes(text.replace("R(0.1)", "R(0.2)")) == ["BG271"]
    assert codes(text.replace("run 1 s", "run 2 s")) == ["BG271"]
    assert codes(text.replace("capacity = 1e-4 in", "capacity = 2e-4 in", 1)) == ["BG271"]


def test_a_proof_is_about_an_extended_scene(tmp_path):
    text = WALL + 'scene alone of Wall { observe inside; run 1 s; proof "00"; }'
    assert [d.code for d in check_source(written(tmp_path, text))] == ["BG272"]
