"""`bgc cost`: sizes before and after, what was left out, and variants of every slot."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from model_files import model_text

import bgc
import bgc.library
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.elaboration.elaborate import elaborate
from bgc.elaboration.scenes.variants import Change, variants_of
from bgc.emission.operation_cost import cost_of
from bgc.ir.program import Dropped, Reason
from bgc.options import Options
from bgc.resolution.resolve import load_text
from bgc.runtime.cli.app import application
from bgc.runtime.measuring.scene_cost import cost_report, spectral_radius
from bgc.slicing.slicing_report import dropped_lines, folded_lines

MOUNTS = model_text("cost_mounts")


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("cost") / "engine.bg"
    path.write_text(MOUNTS)
    return path


def test_all_models_that_fit_a_slot_are_variants() -> None:
    package = load_text(MOUNTS, "engine.bg")
    found = variants_of(package, elaborate(package))
    assert found == tuple(Change("mount", t) for t in ("Loose[2]", "Pair", "Stop[2]"))


def test_the_present_filling_is_no_variant() -> None:
    package = load_text(MOUNTS, "engine.bg")
    found = variants_of(package, elaborate(package, uses=[("mount", "Stop[2]")]))
    assert Change("mount", "Spring[2]") in found
    assert Change("mount", "Stop[2]") not in found


def test_a_use_on_request_goes_before_the_scenes(file: Path) -> None:
    text = MOUNTS.replace("scene s of Engine {", "scene s of Engine { use mount = Stop[2];")
    package = load_text(text, "engine.bg")
    assert [s.filled_by for s in elaborate(package).slots] == ["Stop"]
    asked = elaborate(package, uses=[("mount", "Loose[2](k = 5)")])
    assert [s.filled_by for s in asked.slots] == ["Loose"]
    assert [p.name for p in asked.parameters] == ["mount.k"]


@pytest.mark.parametrize(
    ("use", "code"),
    [(("mount", "Nothing[2]"), "BG201"), (("hub", "Stop[2]"), "BG603"), (("mount", "2 +"), "BG1")],
)
def test_a_wrong_use_is_told(use: tuple[str, str], code: str) -> None:
    with pytest.raises(BgError) as caught:
        elaborate(load_text(MOUNTS, "engine.bg"), uses=[use])
    assert caught.value.diagnostics[0].code.startswith(code)


def test_the_report_of_an_engine(file: Path) -> None:
    report = cost_report(file, Options(), 10)
    assert report.whole.states == 4 and report.cost.states == 2
    assert report.cost.rhs < report.whole.rhs
    assert [d.reason for d in report.dropped] == [Reason.ZERO] * 2
    assert "mount.rod.q[2]" in {d.name for d in report.dropped}
    assert dict(report.folded) == {"mount.loss": 0.0}
    # Both inertias move together, the arm twice as fast: 1 + 4 on a spring of 4e6.
    assert report.stiffness == pytest.approx(math.sqrt(4e6 / 5), rel=1e-9)
    rows = {row.variant.value: row for row in report.variants}
    pair, stop, loose = rows["Pair"], rows["Stop[2]"], rows["Loose[2]"]
    assert pair.cost is not None and pair.stiffness == pytest.approx(math.sqrt(3 / 5))
    assert stop.cost is not None and stop.cost.states == 0
    assert loose.cost is None and "`k` has no value" in loose.refused


def test_variants_that_run_are_measured(file: Path) -> None:
    report = cost_report(file, Options(), 9)
    times = {v.variant.value: v.measured and v.measured.step_seconds for v in report.variants}
    assert report.measured is not None and report.measured.step_seconds > 0
    assert times["Pair"] > 0 and times["Loose[2]"] is None  # type: ignore[operator]
    assert cost_report(file, Options(), 0).skipped == 3


@pytest.mark.slow
def test_the_spectral_radius_is_that_of_the_emitted_jacobian() -> None:
    file = Path(bgc.library.__path__[0]) / "scenes" / "planar_crane.bg"
    lowered = compile_scene(file, Options("planar"), until="lower").lowered
    model = bgc.compile(file, "planar")
    instance = model.parameters.instance({})
    instance.reset(0.0)  # the given start, not the start at rest
    largest = np.abs(model.eigenvalues(instance.state.copy())).max()
    assert spectral_radius(lowered) == pytest.approx(largest, rel=1e-9)
    assert cost_of(lowered).states == 37


def test_the_stiffness_of_equations_that_couple_rates(tmp_path: Path) -> None:
    """Coils of 2 and 3 H with 1 H in common, and resistors of 5 and 1 ohm."""
    source = tmp_path / "coils.bg"
    source.write_text(
        "model Coils { state i = 1; state j = 0;"
        " equation 2*der(i) + der(j) = -5*i; equation der(i) + 3*der(j) = -j; }"
        "scene s of Coils { observe i; run 1; }"
    )
    rates = np.linalg.eigvals(-np.linalg.solve([[2, 1], [1, 3]], np.diag([5, 1])))
    found = spectral_radius(compile_scene(source, Options(), until="lower").lowered)
    assert found == pytest.approx(np.abs(rates).max())


def test_a_law_that_switches_is_taken_as_it_is_at_the_start(tmp_path: Path) -> None:
    source = tmp_path / "lag.bg"
    source.write_text(
        "model Lag { state x = 1; der(x) = -(if x > 0.5 then 7 else 2)*x; }"
        "scene s of Lag { observe x; run 1; }"
    )
    assert spectral_radius(
        compile_scene(source, Options(), until="lower").lowered
    ) == pytest.approx(7)


def test_the_command_prints_tables_and_json(file: Path) -> None:
    text = CliRunner().invoke(application, ["cost", str(file), "-q"]).output
    assert "written  compiled" in text and "LU by unrolled code" in text
    assert "starts at zero and stays there" in text
    assert "mount = Loose[2] does not fit as it is" in text
    shown = CliRunner().invoke(application, ["cost", str(file), "--json", "--variants", "1"])
    data = json.loads(shown.output)
    assert data["compiled"]["states"] == 2 and data["skipped"] == 2
    assert data["folded"] == {"mount.loss": 0.0}


def test_uses_reach_the_model_and_the_command_line(file: Path) -> None:
    model = bgc.compile(file, uses={"mount": "Spring[2](k = 1)"})
    largest = np.abs(model.eigenvalues()).max()
    assert largest == pytest.approx(math.sqrt(1 / 5))
    arguments = ["run", str(file), "--use", "mount=Spring[2](k = 1)", "--out", "-", "-q"]
    out = CliRunner().invoke(application, arguments).output
    assert float(out.splitlines()[-1].split(",")[1]) == pytest.approx(
        model.simulate()["block.p"][-1, 0], rel=1e-12
    )


def test_lines_of_what_was_left_out() -> None:
    zero, unread = Reason.ZERO, Reason.UNREAD
    dropped = [
        Dropped("ship.p[2]", zero),
        Dropped("ship.p[4]", zero),
        Dropped("boom.lock.q[1]", unread),
        Dropped("boom.lock.p[1]", unread),
        Dropped("boom.angle", zero),
        Dropped("mast[2].x", unread),
        Dropped("top", unread),
    ]
    assert dropped_lines(dropped, ["ship.p[1]", "mast[1].x"]) == (
        "`ship.p[2, 4]`: starts at zero and stays there",
        "`boom.lock` (2 states): nothing that the scene reads depends on it",
        "`boom.angle`: starts at zero and stays there",
        "`mast[2]` (1 state): nothing that the scene reads depends on it",
        "`top`: nothing that the scene reads depends on it",
    )


def test_folded_components_are_named() -> None:
    """D1: deck_at = [-20, 0, 3] was said to be folded to 0."""
    assert folded_lines([("a[3].M[1,2]", 0.0), ("a[3].M[2,1]", 0.0), ("b", 1.0)]) == (
        "`a[3].M[1,2]`, `a[3].M[2,1]` = 0",
        "`b` = 1",
    )
    assert folded_lines([("deck_at[2]", 0.0)]) == ("`deck_at[2]` = 0",)
    many = [(f"D[1,{k}]", 0.0) for k in range(1, 7)]
    assert folded_lines(many) == ("6 components of `D` = 0",)


def test_the_whole_model_and_other_slots_can_be_shown(file: Path) -> None:
    def shown(*arguments: str) -> str:
        command = ["show", str(file), "--after", "slice", *arguments]
        return CliRunner().invoke(application, command).output

    assert "dropped" in shown() and "dropped" not in shown("--whole")
    assert "rod.q[2]" in shown("--whole")
    assert "rod.q" not in shown("--use", "mount=Stop[2]")
