"""`bgc activity` on models whose activities are known."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.linalg import expm

from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.activity.activity import activity_report
from bgc.runtime.activity.powers import Activity, below
from bgc.runtime.cli.app import application
from bgc.runtime.compiling import compile_model

pytestmark = pytest.mark.slow

MODELS = Path(__file__).parents[1] / "models" / "activity.bg"


def report_of(scene, **options):
    return activity_report(compile_model(MODELS, scene), **options)


def test_two_resistors_share_by_their_resistance():
    report = report_of("divider")
    found = {a.element: a.activity for a in report.activities}
    assert found == {"large": pytest.approx(2**2 * 3 * 5), "small": pytest.approx(2**2 * 2 * 5)}
    assert [a.element for a in report.activities] == ["large", "small"]
    assert report.spread < 1e-12


def free_motion(A, b, times):
    """x' = A x + b from rest, at all times."""
    whole = np.block([[A, b[:, None]], [np.zeros((1, len(b) + 1))]])
    start = np.append(np.zeros(len(b)), 1.0)
    return np.array([expm(whole * t) @ start for t in times])[:, :-1]


def train(times):
    """Position and speed of the first mass: by a spring of 2e4 N/m, and joined."""
    k, link, m, small, d = 100.0, 2e4, 1.0, 0.1, 1e-6
    # q, v, deflection of the link (first minus second), speed of the second
    A = np.array(
        [
            [0, 1, 0, 0],
            [-k / m, -d / m, -link / m, 0],
            [0, 1, 0, -1],
            [0, 0, link / small, 0],
        ]
    )
    sprung = free_motion(A, np.array([0, 1 / m, 0, 0]), times)
    both = m + small
    joined = free_motion(np.array([[0, 1], [-k / both, -d / both]]), np.array([0, 1 / both]), times)
    return sprung, joined, link


def test_a_stiff_spring_that_does_little_is_made_rigid_at_the_error_that_this_has():
    report = report_of("train", negligible=0.05)
    times = np.linspace(0, 1, 2001)
    sprung, _, link = train(times)
    fine, joined, _ = train(np.linspace(0, 1, 100_001))  # errors between the rows count too
    errors = np.abs(fine[:, :2] - joined).max(axis=0) / np.ptp(fine[:, :2], axis=0)
    rigid = next(t for t in report.trials if t.changes[0].statement == "use link = Joined;")
    assert rigid.error == pytest.approx(errors.max(), rel=1e-3)
    assert rigid.error < report.limit
    assert rigid.cost.states == 2 < report.cost.states
    assert report.together is not None
    lines = {change.statement for change in report.together.changes}
    assert "use link = Joined;" in lines
    assert "use link = Open;" not in lines

    power = np.abs(link * sprung[:, 2] * (sprung[:, 1] - sprung[:, 3]))
    spring = next(a for a in report.activities if a.element == "link.spring")
    assert spring.activity == pytest.approx(np.trapezoid(power, times), rel=1e-4)
    assert spring.part == "link"


def test_a_part_is_not_another_whose_name_begins_like_it():
    found = [Activity("link.spring", "C", 2.0), Activity("linkage.spring", "C", 3.0)]
    assert below(found, "link") == 2
    assert below(found, "lin") is None


def test_what_saves_nothing_is_no_variant():
    report = report_of("train", negligible=0.05)
    rigid = next(t for t in report.trials if t.changes[0].statement == "use link = Joined;")
    assert rigid.changes in report.variants
    assert rigid.changes not in replace(report, cost=rigid.cost, together=None).variants


def test_letting_go_is_tried_and_found_too_far_off():
    report = report_of("train", negligible=0.05)
    (open_,) = (t for t in report.trials if t.changes[0].statement == "use link = Open;")
    assert open_.error > report.limit


def test_an_element_is_switched_off_by_its_parameter():
    report = report_of("train", negligible=0.05)
    statements = {t.changes[0].statement for t in report.trials}
    assert "set link.stiffness = 0;" in statements


def test_what_other_laws_hold_too_is_no_switch(tmp_path):
    path = tmp_path / "shared.bg"
    path.write_text(
        "model M { param c = 1e-4 ohm; param d = 1e-4 ohm; push : Se(e = 1 V); loop : J1;"
        " main : R(1 ohm + c); little : R(c); small : R(d); push -> loop;"
        " loop -> main, little, small; }"
        "scene s of M { observe loop.f; run 1 s; }"
    )
    report = activity_report(compile_model(path))
    assert [t.changes[0].statement for t in report.trials] == ["set d = 0;"]


def test_values_that_are_set_in_the_model_are_those_of_its_changes_too(tmp_path):
    """The current of 1 V through 100 ohm: a set value that trials lost would be off by 99 %."""
    path = tmp_path / "set.bg"
    path.write_text(
        "model M { param r = 1 ohm; param d = 1e-3 ohm; push : Se(e = 1 V); loop : J1;"
        " main : R(r); small : R(d); push -> loop; loop -> main, small; }"
        "scene s of M { observe loop.f; require loop.f within 1 mA; run 1 s; }"
    )
    model = compile_model(path)
    model.parameters["r"] = 100
    report = activity_report(model)
    assert report.total == pytest.approx(1 / 100.001)
    (trial,) = report.trials
    assert trial.error == pytest.approx((1 / 100 - 1 / 100.001) / 1e-3)


RESISTORS = """model M { param a = 1e-4 ohm; param b = 0 ohm; param c = 2*b;
  push : Se(e = 1 V); loop : J1; push -> loop;
  main : R(1 ohm); r1 : R(a); r2 : R(b); r3 : R(c); loop -> main, r1, r2, r3; }
scene s of M { keep b; observe loop.f; run 1 s; }
"""


@pytest.mark.parametrize(
    ("given", "tried"),
    [
        ({}, {"a"}),
        ({"a": 0.0}, set()),
        ({"a": 0.0, "b": 1e-4}, {"b", "c"}),
        ({"c": 1e-4}, {"a", "c"}),
    ],
)
def test_parameters_are_tried_at_zero_by_their_present_values(tmp_path, given, tried):
    """By those that are set, in the model or by `--set`, and by those that are computed of them."""
    path = tmp_path / "resistors.bg"
    path.write_text(RESISTORS)
    model = compile_model(path)
    for name, value in given.items():
        model.parameters[name] = value
    report = activity_report(model)
    assert {trial.changes[0].name for trial in report.trials} == tried
    assert all(trial.error is not None for trial in report.trials)
    settings = [f"--set={name}={value}" for name, value in given.items()]
    printed = CliRunner().invoke(application, ["activity", str(path), *settings, "--json", "-q"])
    assert printed.exit_code == 0, printed.stderr
    statements = json.dumps(json.loads(printed.stdout)["trials"])
    assert {name for name in "abc" if f"set {name} = 0;" in statements} == tried


def test_changes_that_will_do_one_by_one_but_not_together_are_given_up(tmp_path):
    """Two masses held together, each on a weak spring that takes half a per cent of their way."""
    path = tmp_path / "springs.bg"
    path.write_text(
        "model M { param a = 0.08 N/m; param b = 0.07 N/m; push : Se(e = 1 N); left : J1;"
        " right : J1; gap : J0; m1 : I(1 kg); m2 : I(1 kg); c1 : C(stiffness = a);"
        " c2 : C(stiffness = b); between : C(stiffness = 1 kN/m); push -> left;"
        " left -> m1, c1; left -> gap -> right; gap -> between; right -> m2, c2; }"
        "scene s of M { observe c1.q; solver rodas5p(rtol = 1e-8); run 1.5 s; }"
    )
    report = activity_report(compile_model(path), negligible=0.2)
    errors = {trial.changes[0].name: trial.error for trial in report.trials}
    assert max(errors["a"], errors["b"]) < report.limit < errors["a"] + errors["b"]
    (left,) = report.together.changes
    assert errors[left.name] == min(errors["a"], errors["b"])


def test_what_a_scene_requires_decides():
    report = report_of("exact", negligible=0.05)
    assert report.required and report.limit == 1
    assert all(t.error is None or t.error > 1 for t in report.trials if t.changes[0].is_use)


def test_only_what_carries_little_is_tried():
    assert report_of("train", negligible=0.0).trials == ()


def test_a_scene_that_observes_nothing_is_refused(tmp_path):
    path = tmp_path / "m.bg"
    path.write_text("model M { s : Se(e = 1); r : R(1); s -> r; }\nscene s of M { run 1 s; }")
    with pytest.raises(BgError) as problem:
        activity_report(compile_model(path))
    assert [d.code for d in problem.value.diagnostics] == ["BG088"]


def run(*arguments):
    return CliRunner().invoke(application, ["activity", str(MODELS), *arguments])


def test_the_command_prints_the_lines_for_the_scene():
    done = run("--scene", "train", "--negligible", "0.05")
    assert done.exit_code == 0
    assert "use link = Joined;" in done.output.split("lines for the scene")[1]
    assert "error too large" in done.output


def test_the_command_prints_json():
    found = json.loads(run("--scene", "divider", "--json").output)
    assert [e["element"] for e in found["elements"]] == ["large", "small"]
    assert found["trials"] == []


def test_numbers_that_make_no_sense_are_refused():
    for wrong in ({"duration": -1.0}, {"duration": 0.0}, {"budget": 0.0}, {"within": -1.0}):
        with pytest.raises(BgError) as problem:
            report_of("divider", **wrong)
        assert [d.code for d in problem.value.diagnostics] == ["BG066"]


def test_elements_of_the_scenes_own_model_are_listed_by_themselves():
    lines = [line.split() for line in run("--scene", "divider").output.splitlines()]
    assert ["large", "60", "J", "60.00%", "60.00%"] in lines
    assert ["small", "40", "J", "40.00%", "100.00%"] in lines
