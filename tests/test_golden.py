"""Golden outputs of the passes and the emitted C, for models with a known answer.

A golden file alone proves nothing: the same model is compiled with warnings as errors, run, and
compared with an independent answer, here (`ANSWERS`) or in the test that `GOLDENS` names.
`pytest tests/test_golden.py --bless` rewrites the files.
"""

import ast
import difflib
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import bgc
from bgc.building.build import runtime_directory
from bgc.building.toolchain import find_toolchain
from bgc.driver import Stages, compile_scene
from bgc.emission.emit import amalgamate, content_of
from bgc.grammar.syntax import File, Model, Scene
from bgc.options import Options
from bgc.printing.stages import show_pass, show_syntax

Array = npt.NDArray[np.float64]
Answer = Callable[[Array], Mapping[str, Array]]

TESTS = Path(__file__).parent
LIBRARY = TESTS.parent / "library"
MODELS = TESTS / "models"
GOLDEN = TESTS / "golden"
STRICT = (
    "-std=c11",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wpedantic",
    "-Wdouble-promotion",
    "-Werror",
)
PASSES = {"graph.txt", "causality.txt", "equations.txt"}
# The C of these is blessed for its readers; that of the others by its operations and a digest.
WITH_C = (
    "series_rlc",  # a linear model
    "duffing",  # an energy
    "dc_motor",  # a gyrator
    "gear_train",  # dependent inertias
    "linear_loop",  # an algebraic loop, solved
    "diodes",  # nonlinear loops
    "mass_matrix",  # algebraic equations that stay
    "ball",  # an event
)


@dataclass(frozen=True, slots=True)
class Golden:
    """A scene whose passes are pinned, and the test that compares it with an independent answer.

    `check` is FILE::TEST below `tests`; empty where `ANSWERS` has the answer. Of a `large` scene
    the syntax and the text of the C are left out; its functions are pinned by their operations.
    """

    file: Path
    scene: str
    check: str = ""
    large: bool = False


def model(name: str, scene: str, check: str = "", large: bool = False) -> Golden:
    return Golden(TESTS / "models" / f"{name}.bg", scene, check and f"physics/{check}", large)


def example(name: str, scene: str, check: str) -> Golden:
    return Golden(LIBRARY / "examples" / f"{name}.bg", scene, f"physics/test_examples.py::{check}")


def crane(name: str, scene: str, check: str) -> Golden:
    return Golden(LIBRARY / "scenes" / f"{name}.bg", scene, f"physics/{check}", large=True)


GOLDENS = {
    # one-ports and the junctions
    "series_rlc": model("series_rlc", "step_response"),
    "parallel_rlc": model("parallel_rlc", "decay"),
    "two_lags": model("two_lags", "step_response"),
    "duffing": model("duffing", "release"),
    "turned_law": model(
        "loops", "turned_tank", "test_loops.py::test_a_tank_empties_as_torricelli_says"
    ),
    "junction_loops": model(
        "loops", "bridge", "test_loops.py::test_a_bridge_with_nonlinear_branches"
    ),
    # two-ports
    "dc_motor": model("dc_motor", "start"),
    "gyrator_ring": model(
        "gyrator_ring",
        "free",
        "test_gyrator_ring.py::test_charges_on_a_ring_of_gyrators_follow_the_matrix_exponential",
    ),
    "gear_train": model(
        "merged", "gear_train", "test_merged.py::test_a_gear_train_turns_as_one_inertia"
    ),
    "double_pendulum": model(
        "pendulums", "double", "test_merged.py::test_double_pendulum_moves_as_lagrange_says"
    ),
    "modulus_through_zero": model(
        "loops", "lever", "test_loops.py::test_a_loop_through_a_modulus_that_passes_zero"
    ),
    "jacobian": model("typologies", "planar", "test_typologies.py::test_closed_forms_at_the_start"),
    # fields, wide bonds, Mux and Demux
    "slider": model("merged", "slider", "test_merged.py::test_a_slider_on_a_cart"),
    "tumbling": model(
        "tumbling", "quaternion", "test_free_body.py::test_energy_and_inertial_momenta_are_kept"
    ),
    "handle": model(
        "handle",
        "rate",
        "test_handle.py::test_the_coupling_stretches_by_crane_minus_hand_and_pulls_the_crane_back",
    ),
    "microphone": model(
        "ic_fields",
        "microphone",
        "test_ic_fields.py::test_a_microphone_shares_its_charge_and_its_plate_moves_with_the_dust",
    ),
    # dependent storage and algebraic equations
    "two_masses": model("merged", "two_masses", "test_merged.py::test_two_masses_on_one_junction"),
    "driven_capacitors": model(
        "merged", "driven", "test_merged.py::test_capacitors_on_a_source_follow_it"
    ),
    "linear_loop": model("loops", "ladder", "test_loops.py::test_the_resistors_around_a_capacitor"),
    "diodes": model(
        "loops", "rectifier", "test_loops.py::test_a_rectifier_with_every_kind_of_method"
    ),
    "mass_matrix": model(
        "ivp/transistor_amplifier",
        "ivp",
        "test_ivp.py::test_digits_are_those_of_the_tolerance",
    ),
    # events
    "ball": model("events", "ball", "test_events.py::test_a_ball_on_a_spring"),
    "slack_rope": model("events", "slack_rope", "test_events.py::test_a_slack_rope"),
    "switched_equation": model(
        "events", "loop", "test_events.py::test_a_switch_in_an_algebraic_equation"
    ),
    # the tutorials; that of the car on its track has a device
    "example_motor": example(
        "motor_gearbox", "drive", "test_the_elastic_drive_in_time_and_frequency"
    ),
    "example_tanks": example("two_tanks", "tanks", "test_two_tanks_by_their_levels"),
    "example_car": example("quarter_car", "on_track", "test_the_car_on_the_recorded_road"),
    "example_car_in_matrices": example(
        "quarter_car", "matrices", "test_the_car_in_matrices_moves_as_the_other"
    ),
    "example_lift": example("hydraulic_cylinder", "lift", "test_the_lift_by_its_pressures"),
    "example_pendulum": example("hanging_load", "pendulum", "test_the_pendulum"),
    # the paper's crane
    "crane_compliant": crane(
        "two_beam_crane",
        "two_beam_crane",
        "test_experiment.py::test_the_tip_follows_and_the_load_is_felt",
    ),
    "crane_planar": crane(
        "planar_crane", "planar", "test_planar_crane.py::test_the_tip_moves_as_in_the_whole_model"
    ),
    "crane_rigid": model(
        "rigid_crane", "afloat", "test_rigid_crane.py::test_accelerations_with_added_mass", True
    ),
}


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


@cache
def compiled(name: str) -> Stages:
    golden = GOLDENS[name]
    return compile_scene(golden.file, Options(golden.scene), until="emit")


def syntax_of(file: File, scene: str) -> str:
    """The scene and its model; what else the file declares belongs to other goldens."""
    (found,) = (d for d in file.declarations if isinstance(d, Scene) and d.name == scene)
    kept = tuple(
        d
        for d in file.declarations
        if d is found or (isinstance(d, Model) and d.name == found.model.name)
    )
    return show_syntax(replace(file, declarations=kept))


def facts_of(stages: Stages) -> str:
    """The C in short: sizes, operations of a call of each function, and a digest."""
    emitted, program = stages.emitted, stages.lowered.program
    lines = [
        f"{len(program.states)} states, {len(program.parameters)} parameters, "
        f"{len(program.observations)} outputs, {len(emitted.units)} units of C",
        "",
        "operations",
        *(f"  {name}: {count}" for name, count in emitted.operations),
        "",
        "states",
        *(f"  {state.name} ({state.unit})" for state in program.states),
        "",
        "outputs",
        *(f"  {output.name} ({output.unit})" for output in program.observations),
        "",
        f"digest of the C: {content_of(emitted)}",
    ]
    return "".join(f"{line}\n" for line in lines)


def made(name: str) -> dict[str, str]:
    """The golden files of a scene by their names, as they are now.

    The C is without the hash of its sources, which changes with every comment of the library.
    """
    golden, stages = GOLDENS[name], compiled(name)
    files = {
        "graph.txt": show_pass("elaborate", stages),
        "causality.txt": show_pass("causality", stages),
        "equations.txt": show_pass("slice" if golden.large else "equations", stages),
    }
    if not golden.large:
        files["syntax.txt"] = syntax_of(stages.package.root.file, golden.scene)
    if name not in WITH_C:
        return files | {"model.txt": facts_of(stages)}
    code = show_pass("emit", stages).replace(stages.emitted.source_hash, "of its sources")
    return files | {"model.c": code}


@pytest.mark.parametrize("name", GOLDENS)
def test_passes_and_c_are_as_blessed(name, bless):
    folder = GOLDEN / name
    files = made(name)
    if bless:
        folder.mkdir(parents=True, exist_ok=True)
        for file, text in files.items():
            (folder / file).write_text(text)
    for file, text in files.items():
        blessed = (folder / file).read_text() if (folder / file).exists() else ""
        difference = difflib.unified_diff(
            blessed.splitlines(), text.splitlines(), f"golden/{name}/{file}", "now", lineterm=""
        )
        assert text == blessed, "\n".join([*difference, "", "pytest --bless rewrites it"])


@pytest.mark.parametrize("name", ANSWERS)
def test_model_of_the_golden_files_is_right(name):
    result = bgc.compile(GOLDENS[name].file, GOLDENS[name].scene).simulate()
    for column, expected in ANSWERS[name](result.time).items():
        np.testing.assert_allclose(result[column], expected, rtol=1e-8, atol=1e-8, err_msg=column)


@pytest.mark.parametrize("name", GOLDENS)
def test_every_golden_has_an_independent_check(name):
    golden = GOLDENS[name]
    if not golden.check:
        assert name in ANSWERS
        return
    file, _, test = golden.check.partition("::")
    text = (TESTS / file).read_text("utf-8")
    functions = {
        node.name: node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.FunctionDef)
    }
    assert test in functions, f"{file} has no {test}"
    assert golden.file.stem in text or golden.file.stem in (TESTS / "models/ivp").iterdir()
    assert golden.scene in text


@pytest.mark.slow
@pytest.mark.parametrize("name", GOLDENS)
def test_c_compiles_with_warnings_as_errors(name, tmp_path):
    """The model is compiled, and one file of it and the runtime read; test_emit.py runs one."""
    emitted, runtime = compiled(name).emitted, runtime_directory()
    (tmp_path / "whole.c").write_text(amalgamate(emitted, runtime))
    for unit in emitted.units:
        (tmp_path / f"{unit.name}.c").write_text(unit.text)
        for file, content in unit.files:
            (tmp_path / file).write_bytes(content)
    compiler = [*find_toolchain().command, *STRICT, "-O0", f"-I{runtime}", "-c"]
    own = [f"{unit.name}.c" for unit in emitted.units]
    for command in ([*compiler, *own], [*compiler, "-fsyntax-only", "whole.c"]):
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr


def test_no_golden_folder_is_an_orphan():
    assert {folder.name for folder in GOLDEN.iterdir() if folder.is_dir()} == set(GOLDENS)
    for name, golden in GOLDENS.items():
        found = {path.name for path in (GOLDEN / name).iterdir()}
        syntax = set() if golden.large else {"syntax.txt"}
        assert found == PASSES | syntax | {"model.c" if name in WITH_C else "model.txt"}


def test_the_golden_files_stay_small_enough_to_read():
    size = sum(path.stat().st_size for path in GOLDEN.rglob("*") if path.is_file())
    assert size < 1.5e6
