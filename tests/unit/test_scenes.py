"""Statements of scenes: edits, devices, observations, the facts of a run."""

import math

import pytest
from model_files import model_text
from refusals import refusal

from bgc.algebra.dag import Kind
from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.elaborate import elaborate
from bgc.ir.graph import FlatGraph
from bgc.language.solver import Solver
from bgc.resolution.resolve import load_text

MODEL = model_text("scenes")


def scene(items: str, **sets: str) -> FlatGraph:
    text = f"{MODEL}scene s of Handle {{ {items} }}"
    return elaborate(load_text(text), None, tuple(sets.items()))


TRACE = 'device hand2 = trace(file = "a.csv", scale = 2); drive x = hand2.position;'


def test_facts_of_the_run():
    facts = scene(
        "drive x = [0, 0, 1]; observe height; solver rodas5p(rtol = 1e-8, step = 1 ms);"
        " step 2 ms; run 1 min every 10 ms; deadline 500 us;"
    ).scene
    assert facts.name == "s"
    assert facts.model == "Handle"
    assert facts.solver.name == "rodas5p"
    assert facts.solver == Solver("rodas5p", rtol=1e-8, step=1e-3)
    assert (facts.step, facts.duration, facts.every, facts.deadline) == (2e-3, 60, 0.01, 5e-4)


def test_a_scene_that_says_nothing_leaves_it_open():
    facts = scene("drive x = zeros(3); observe height;").scene
    assert facts.solver == Solver()
    assert (facts.step, facts.duration, facts.every, facts.deadline) == (None,) * 4


def test_a_number_without_unit_is_in_seconds():
    assert scene("drive x = zeros(3); run 3;").scene.duration == 3
    assert scene("drive x = zeros(3); run 2*pi;").scene.duration == 2 * math.pi


def test_scenes_are_chosen_by_name_or_the_first():
    still = "of Handle { drive x = zeros(3); }"
    text = f"{MODEL} scene a {still} scene b {still}"
    assert elaborate(load_text(text)).scene.name == "a"
    assert elaborate(load_text(text), "b").scene.name == "b"


def test_columns_are_named_by_path_or_alias():
    graph = scene(
        "drive x = zeros(3); observe force, height as h, -force.z as down,"
        " energy.stored, energy.residual as slip;"
    )
    assert graph.scene.columns == (
        "force[1]", "force[2]", "force[3]", "h", "down", "energy.stored", "slip",
    )  # fmt: skip
    assert [found.account for found in graph.scene.accounts] == ["stored", "residual"]
    assert [o.unit for o in graph.observations] == ["N", "N", "N", "m", "N"]


def test_devices_give_channels_and_take_commands():
    graph = scene(TRACE + "drive gain = hand2.buttons[1]; drive hand2.force = force;")
    (device,) = graph.devices
    assert (device.name, device.driver) == ("hand2", "trace")
    assert device.options == (("file", "a.csv"), ("scale", "2.0"))
    assert device.inputs[:3] == (("position", 1), ("position", 2), ("position", 3))
    assert ("buttons", 1) in device.inputs
    assert device.commands == (("force", 1), ("force", 2), ("force", 3))
    assert len(device.values) == 3


def test_input_symbols_follow_each_other_over_devices():
    text = f"""{MODEL}
      model Two {{ a : Handle; b : Handle; }}
      scene s of Two {{
        device left = trace(file = "l.csv"); device right = trace(file = "r.csv");
        drive a.x = left.position; drive b.x = right.position;
        drive right.force[3] = b.force[3];
        observe b.height;
      }}
    """
    graph = elaborate(load_text(text))
    left, right = graph.devices
    assert (left.first_input, right.first_input) == (0, 3)
    assert right.commands == (("force", 3),)
    symbol = graph.dag.symbol_of(graph.observations[0].node)
    assert (symbol.kind, symbol.index) == (Kind.INPUT, 5)


def test_requirements_and_kept_paths():
    graph = scene("drive x = zeros(3); require force within 5 N; keep spring; keep height;")
    assert [(r.name, r.tolerance) for r in graph.requirements] == [
        ("force[1]", 5),
        ("force[2]", 5),
        ("force[3]", 5),
    ]
    assert graph.kept == ("spring", "height")


def test_the_command_line_has_the_last_word():
    graph = scene("drive x = zeros(3); set limit = 20 N;", limit="30 N")
    (limit,) = (p for p in graph.parameters if p.name == "limit")
    assert graph.dag.value(limit.value) == 30
    assert (limit.low, limit.high, limit.unit) == (0, 100, "N")


@pytest.mark.parametrize(
    ("target", "value", "code"),
    [
        ("limit", "3 m", "BG306"),
        ("limit", "300", "BG239"),
        ("limt", "3", "BG211"),
        ("spring.k", "3", "BG419"),
        ("height", "3", "BG603"),
        ("limit", "3 +", "BG101"),
    ],
)
def test_mistakes_on_the_command_line(target, value, code):
    with pytest.raises(BgError) as caught:
        scene("drive x = zeros(3);", **{target: value})
    assert {d.code for d in caught.value.diagnostics} == {code}


def test_an_input_without_a_value_names_the_drive():
    problem = refusal(scene, "observe height;")
    assert problem.code == "BG218"
    assert "drive" in problem.help


def test_plots_of_components_and_against_the_time():
    """D3: a component was refused, whether by name or not, and so was `against time`."""
    facts = scene(
        "drive x = zeros(3); observe force, height; plot force.x, force[3] against height;"
        " plot force.y against time; plot height against force.z;"
    ).scene
    assert [(panel.columns, panel.across) for panel in facts.plots] == [
        (("force[1]", "force[3]"), "height"),
        (("force[2]",), "time"),
        (("height",), "force[3]"),
    ]


def test_a_wrong_observation_has_no_errors_that_follow_from_it():
    with pytest.raises(BgError) as error:
        scene("drive x = zeros(3); observe spring.tension, hight as h; plot h, spring.tension;")
    assert sorted(d.code for d in error.value.diagnostics) == ["BG211", "BG419"]
