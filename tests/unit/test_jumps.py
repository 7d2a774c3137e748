"""Jumps in the language and in the passes: words, format, slicing, linear form, ensembles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from model_files import model_text
from parsed import items

import bgc
from bgc.driver import compile_scene
from bgc.grammar import syntax
from bgc.linearising.analysis_scene import open_scene
from bgc.options import Options
from bgc.printing.stages import show_equations

MODELS = Path(__file__).parents[1] / "models"


@pytest.mark.parametrize(
    "condition", ["z > 0", "(z > 0)", "-z > 0", "not z > 0", "1 < z", "when > reset", "\n  z > 0"]
)
def test_a_when_begins_before_an_expression(condition):
    (item,) = items(f"when {condition} {{ reset reset = when; reset a.b[1].p = 2; }}")
    assert isinstance(item, syntax.When)
    assert [reset.target.span.text for reset in item.resets] == ["reset", "a.b[1].p"]


def stages(tmp_path, text, until="slice"):
    path = tmp_path / "m.bg"
    path.write_text(text)
    return compile_scene(path, Options(verify=True), until=until)


MODEL = model_text("jumps")


def test_slicing_keeps_what_a_reset_needs(tmp_path):
    """`level` is in the condition; `still` never changes; nothing observed needs the others."""
    sliced = stages(tmp_path, MODEL).sliced
    assert [state.name for state in sliced.states] == ["x", "level"]
    (jump,) = sliced.jumps
    assert [reset.state for reset in jump.resets] == [0]
    assert sliced.dag.value(jump.resets[0].value) == 5
    assert "when 1 = x > level\n  when 1: x = 5\n" in show_equations(sliced).replace(
        "level < x", "x > level"
    )


def test_a_state_that_only_a_jump_changes_is_kept(tmp_path):
    text = MODEL.replace("observe x;", "observe count;")
    sliced = stages(tmp_path, text).sliced
    assert [state.name for state in sliced.states] == ["x", "level", "count"]
    assert len(sliced.jumps) == 2


def test_a_condition_that_the_scene_decides_leaves_no_jump(tmp_path):
    text = "model M { param on = 1;  state x = 0;  der(x) = 1;\n"
    text += "  when on*x > 0.5 { reset x = 0; } }\n"
    text += "scene s of M { set on = 0;  observe x;  run 1 s; }"
    assert stages(tmp_path, text).sliced.jumps == ()


def test_a_linear_form_ignores_jumps(tmp_path):
    path = tmp_path / "m.bg"
    path.write_text(MODEL)
    program = open_scene(path, Options(), (), ("x",)).program
    assert [state.name for state in program.states] == ["x"] and program.jumps == ()


def test_jumps_of_what_others_follow_by_their_rate_are_impulses(tmp_path):
    """A capacitor parallel to a source that a reset state gives has impulses of its flow."""
    text = """
    model M {
      state x = 0;  der(x) = 1;
      s : Se(e = x*1 V);  c : C(1 mF);  r : R(1 ohm);  node : J0;
      s -> node -> c, r;
      when x > 1 { reset x = 0; }
    }
    scene s of M { observe c.f; run 1 s; }
    """
    warnings = stages(tmp_path, text, until="equations").equations.warnings
    assert [warning.code for warning in warnings] == ["BG541"]


def test_models_without_jumps_have_no_trace_of_them():
    emitted = compile_scene(MODELS / "events.bg", Options("ball"), until="emit").emitted
    assert "jumps" not in emitted.units[0].parts
    assert not any(word in unit.text for unit in emitted.units for word in ("n_jump", "edge"))


def test_a_run_in_parts_has_the_same_bits():
    """Also where a part ends at a bounce, whose argument still lies beyond its edge."""
    model = bgc.compile(MODELS / "jumps.bg", scene="bounce")
    whole = model.simulate(every=0.01)
    first = np.sqrt(2 / 9.81)
    times = np.array([0.2, first, np.nextafter(first, 1), 0.5, 1.3, 2.0])
    rows = np.full((len(times), model.library.model.n_output), np.nan)
    together = rows.copy()
    for parts, out in ((False, together), (True, rows)):
        instance = model.parameters.instance({})
        assert instance.reset() == 0
        if parts:
            for k in range(len(times)):
                assert instance.run(times[k : k + 1], out[k : k + 1]) == (0, 1)
        else:
            assert instance.run(times, out) == (0, len(times))
    np.testing.assert_array_equal(rows, together)
    np.testing.assert_allclose(rows[-1, 0], whole["height"][-1], atol=1e-10)


def test_ensembles_run_one_by_one():
    model = bgc.compile(MODELS / "jumps.bg", scene="bounce")
    values = [0.9, 0.85, 0.8, 0.75, 0.7]
    many = model.simulate_many({"e": values}, 1.5, every=0.1)
    assert many.alone == "the states of the model jump"
    for k, e in enumerate(values):
        alone = model.simulate(1.5, every=0.1, parameters={"e": e})
        np.testing.assert_array_equal(many.values[k, :, 0], alone["height"])
