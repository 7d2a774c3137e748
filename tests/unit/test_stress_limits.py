"""References of `bgc stress`, and the limits of its drives."""

from __future__ import annotations

from pathlib import Path

from bgc.runtime.compiling import compile_model
from bgc.runtime.model import Model
from bgc.runtime.stress.stress import stress
from bgc.runtime.stress.stress_judge import Verdict

MODELS = Path(__file__).parents[1] / "models" / "stress.bg"


def oscillator(folder: Path, statement: str) -> Model:
    """The oscillator with one more statement in its scene."""
    text = MODELS.read_text()
    head, scene, rest = text.partition("scene oscillator of Oscillator {")
    path = folder / "limits.bg"
    path.write_text(f"{head}{scene}\n  {statement}{rest}")
    return compile_model(path, "oscillator")


def verdict(model: Model, step: str, within: float | None = None) -> Verdict:
    """Result of rk4 with a step."""
    found = stress(model, [f"step={step}, {step}"], solver="rk4", step=1e-3, within=within,
                   fresh=True)  # fmt: skip
    return found.points[0].judgement.verdict


def test_what_a_scene_requires_decides(tmp_path: Path) -> None:
    wide = oscillator(tmp_path, "require spring.q within 1 m;")
    assert verdict(wide, "50 ms") is Verdict.HOLDS
    assert verdict(wide, "50 ms", within=1e-3) is Verdict.DEGRADED
    narrow = oscillator(tmp_path, "require spring.q within 1e-13 m;")
    assert verdict(narrow, "1 ms") is Verdict.DEGRADED
    assert verdict(narrow, "1 ms", within=1e-3) is Verdict.HOLDS


def test_the_ends_of_declared_ranges_are_driven() -> None:
    found = stress(compile_model(MODELS, "oscillator"), budget=1e-9, fresh=True)
    values = {drive.name: drive.values for drive in (*found.drives, *found.skipped)}
    assert {0.0, 1e15} < {*values["k"]}
    assert values["zeta"][-1] == 100
