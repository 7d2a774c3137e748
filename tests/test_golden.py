"""Golden outputs of the passes and the emitted C, for models with a known answer.

A golden file alone proves nothing: the same model is compiled with warnings as errors, run, and
compared with an independent answer. `pytest --bless` rewrites the files.
"""

import difflib
import subprocess
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import bgc
from bgc.building.build import runtime_directory
from bgc.building.toolchain import find_toolchain
from bgc.driver import compile_scene
from bgc.emission.emit import amalgamate
from bgc.options import Options
from bgc.printing.stages import show_pass

Array = npt.NDArray[np.float64]
Answer = Callable[[Array], Mapping[str, Array]]

MODELS = Path(__file__).parent / "models"
GOLDEN = Path(__file__).parent / "golden"
STRICT = ("-std=c11", "-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror")
FILES = {"syntax.txt": "parse", "causality.txt": "causality", "equations.txt": "equations"}


def linear(matrix, start, forcing, names) -> Answer:
    """Columns of x' = A x + b from x0, by the matrix exponential of the augmented system."""
    n = len(start)
    augmented = np.zeros((n + 1, n + 1))
    augmented[:n, :n], augmented[:n, n] = matrix, forcing

    def answer(time: Array) -> Mapping[str, Array]:
        x = np.array([(expm(augmented * t) @ [*start, 1])[:n] for t in time])
        return dict(zip(names, x.T, strict=True))

    return answer


def duffing(time: Array) -> Mapping[str, Array]:
    """q'' = -q - q^3 from q = 1 at rest, by another integrator."""
    exact = solve_ivp(
        lambda _, y: [y[1], -y[0] - y[0] ** 3],
        (0, time[-1]),
        [1, 0],
        "DOP853",
        time,
        rtol=1e-12,
        atol=1e-12,
    )
    return {"position": exact.y[0], "momentum": exact.y[1]}


ANSWERS: dict[str, Answer] = {
    "series_rlc": linear(
        [[-2 / 3, -1 / 3], [1 / 4, 0]], [0, 0], [1 / 3, 0], ["current", "voltage"]
    ),
    "parallel_rlc": linear([[-1, -1], [1, 0]], [1, 1], [0, 0], ["charge", "flux"]),
    "dc_motor": linear([[-2, -0.02], [1, -10]], [0, 0], [2, 0], ["current", "speed"]),
    "two_lags": linear([[-1, 0], [1000, -1000]], [0, 0], [1, 0], ["slow", "fast"]),
    "duffing": duffing,
}


@pytest.mark.parametrize("model", ANSWERS)
def test_passes_and_c_are_as_blessed(model, bless):
    path = MODELS / f"{model}.bg"
    stages = compile_scene(path, Options(), until="emit")
    made = {name: show_pass(after, stages) for name, after in FILES.items()}
    made["model.c"] = show_pass("emit", stages)
    folder = GOLDEN / model
    if bless:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in made.items():
            (folder / name).write_text(text)
    for name, text in made.items():
        blessed = (folder / name).read_text() if (folder / name).exists() else ""
        difference = difflib.unified_diff(
            blessed.splitlines(), text.splitlines(), f"golden/{model}/{name}", "now", lineterm=""
        )
        assert text == blessed, "\n".join([*difference, "", "pytest --bless rewrites it"])


@pytest.mark.parametrize("model", ANSWERS)
def test_model_of_the_golden_files_is_right(model):
    result = bgc.compile(MODELS / f"{model}.bg").simulate()
    for name, expected in ANSWERS[model](result.time).items():
        np.testing.assert_allclose(result[name], expected, rtol=1e-8, atol=1e-8, err_msg=name)


@pytest.mark.parametrize("model", ANSWERS)
def test_self_contained_c_compiles_with_warnings_as_errors(model, tmp_path):
    emitted = compile_scene(MODELS / f"{model}.bg", Options(), until="emit").emitted
    (tmp_path / "model.c").write_text(amalgamate(emitted, runtime_directory()))
    command = [*find_toolchain().command, *STRICT, "-O0", "-c", "model.c"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_no_golden_folder_is_an_orphan():
    assert {folder.name for folder in GOLDEN.iterdir()} == set(ANSWERS)
    for folder in GOLDEN.iterdir():
        assert {path.name for path in folder.iterdir()} == {*FILES, "model.c"}
