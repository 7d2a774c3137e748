"""FMUs, driven by FMPy: descriptions, both kinds of simulation, states, derivatives, failures."""

from __future__ import annotations

import ctypes
import errno
import subprocess
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from click.testing import CliRunner
from fmpy import simulate_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.validation import validate_fmu
from model_files import model_text
from scipy.linalg import expm

import bgc
from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.building.cache import Cache
from bgc.building.toolchain import Toolchain
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.options import Options
from bgc.runtime.cli.app import application
from bgc.runtime.fmi import binaries
from bgc.runtime.fmi.binaries import PLATFORMS, host_platform, read_platforms
from bgc.runtime.fmi.export import fmu_files
from bgc.runtime.fmi.fmu_inputs import ChosenInputs
from bgc.runtime.fmi.fmu_model import prepare_model
from bgc.runtime.fmi.fmu_units import unit_definitions
from bgc.runtime.results.files import write_files

MODELS = Path(__file__).parents[1] / "models"
EVERYTHING = model_text("fmi_everything")
SMALL = model_text("fmi_small")


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> SimpleNamespace:
    """The FMUs of the scenes, without optimisation: compile time is most of this test."""
    folder = tmp_path_factory.mktemp("fmus")
    (folder / "everything.bg").write_text(EVERYTHING)
    (folder / "small.bg").write_text(SMALL)
    (folder / "motion.csv").write_text("time,x,y,z\n0,0,0,0\n9,0,0,0\n")
    platforms = read_platforms(None)
    found = SimpleNamespace(folder=folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(binaries, "_FLAGS", ("-std=c11", "-O0", "-fPIC", "-fvisibility=hidden"))
        for name, file, scene, version, inputs in (
            ("two", "everything.bg", "s", 2, ["pull"]),
            ("three", "everything.bg", "s", 3, ["pull"]),
            ("decay", "small.bg", "plain", 2, ["pull"]),
            ("explosion", "small.bg", "explosion", 2, []),
            ("lift", str(MODELS / "circuits.bg"), "lift", 2, []),
        ):
            options = Options(scene)
            model = prepare_model(folder / file, options, version, inputs)
            files = fmu_files(model, platforms, reference=name == "decay")
            paths = write_files(folder / name, files)
            setattr(found, name, str(paths[0]))
    return found


def opened(path: str, kind: type, **options):
    """An instance, and its value references by name."""
    folder = fmpy.extract(path)
    description = fmpy.read_model_description(folder)
    references = {v.name: v.valueReference for v in description.modelVariables}
    fmu = kind(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="one",
    )
    fmu.instantiate(**options)
    return fmu, references


def initialised(fmu, start=0.0):
    if isinstance(fmu, (FMU3Slave, FMU3Model)):
        fmu.enterInitializationMode(startTime=start)
    else:
        fmu.setupExperiment(startTime=start)
        fmu.enterInitializationMode()
    fmu.exitInitializationMode()


@pytest.mark.parametrize("name", ["two", "three", "decay", "explosion"])
def test_descriptions_are_valid(made, name):
    assert validate_fmu(getattr(made, name)) == []
    variables = fmpy.read_model_description(getattr(made, name)).modelVariables
    assert sum(v.name == "time" for v in variables) == (name == "three")


def test_arrays_terminals_and_units(made):
    folder = Path(fmpy.extract(made.three))
    description = fmpy.read_model_description(str(folder))
    variables = {v.name: v for v in description.modelVariables}
    assert [int(d.start) for d in variables["heading"].dimensions] == [3]
    assert variables["der(heading.state)"].derivative is variables["heading.state"]
    assert variables["k"].variability == "tunable" and variables["start"].variability == "fixed"
    assert (variables["k"].min, variables["k"].max) == ("1.0", "1000.0")
    assert variables["k"].description == "Stiffness of the first spring."
    terminals = (folder / "terminalsAndIcons" / "terminalsAndIcons.xml").read_text()
    assert 'variableName="hand.velocity" memberName="velocity"' in terminals
    units = {
        u.name: dict(u.base)
        for u in unit_definitions([(name, None) for name in ("N*m/rad", "deg", "rpm")])
    }
    assert units["N*m/rad"] == {"kg": "1", "m": "2", "s": "-2", "rad": "-1"}
    assert float(units["deg"]["factor"]) == pytest.approx(np.pi / 180, rel=1e-15)
    assert units["deg"]["rad"] == "1"
    assert {k: units["rpm"][k] for k in ("rad", "s")} == {"rad": "1", "s": "-1"}


@pytest.mark.parametrize("name", ["two", "three"])
@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_both_kinds_of_simulation_agree_with_a_run(made, name, kind):
    result = bgc.compile(str(made.folder / "everything.bg"), "s").simulate()
    found = simulate_fmu(
        getattr(made, name),
        fmi_type=kind,
        relative_tolerance=1e-9 if kind == "ModelExchange" else None,
        stop_time=2,
        output_interval=0.01,
        record_events=False,
    )
    jumps = np.abs(np.asarray(result.time)[:, None] - np.array([0.45, 1.08, 1.53, 1.84])) < 0.02
    smooth = ~jumps.any(axis=1)
    column = (lambda n, k: found[f"{n}[{k + 1}]"]) if name == "two" else lambda n, k: found[n][:, k]
    for base in ("where", "heading"):
        for k in range(3):
            expected = np.asarray(result[f"{base}[{k + 1}]"])
            np.testing.assert_allclose(column(base, k)[smooth], expected[smooth], atol=2e-6)
    np.testing.assert_allclose(found["bounces"][smooth], np.asarray(result["bounces"])[smooth])
    assert np.asarray(result["bounces"])[-1] >= 3
    away = np.abs(found["time"] - 0.6) > 0.005  # a switch of time at an instant comes first
    np.testing.assert_array_equal(found["late"][away], found["time"][away] > 0.6)
    assert abs(found["energy.residual"]).max() < 1e-5
    stored = np.asarray(result["energy.stored"])
    np.testing.assert_allclose(found["energy.stored"][smooth], stored[smooth], atol=1e-5)


def test_an_algebraic_state_near_zero_ends_no_model_exchange(made):
    """At constant speed it is rounding, from which no iteration converges relative to it."""
    kinds = {
        kind: simulate_fmu(
            made.lift,
            fmi_type=kind,
            relative_tolerance=1e-8,
            output_interval=0.01,
            record_events=False,
        )["load.position"]
        for kind in ("CoSimulation", "ModelExchange")
    }
    assert len(kinds["ModelExchange"]) == 201
    np.testing.assert_allclose(kinds["ModelExchange"], kinds["CoSimulation"], atol=1e-6)


def outputs_at(fmu, references, step, count, at):
    names = [references[n] for n in ("where[1]", "where[2]", "momentum", "energy.residual")]
    rows = []
    for k in range(count):
        fmu.doStep(currentCommunicationPoint=k * step, communicationStepSize=step)
        if (k + 1) % at == 0:
            rows.append(fmu.getReal(names))
    return np.array(rows)


def test_co_simulation_does_not_depend_on_the_communication_step(made):
    results = []
    for parts in (1, 4, 64):
        fmu, references = opened(made.two, FMU2Slave)
        initialised(fmu)
        results.append(outputs_at(fmu, references, 0.5 / parts, 4 * parts, parts))
        fmu.freeInstance()
    assert np.array_equal(results[0], results[1]) and np.array_equal(results[0], results[2])


def test_rollback_and_serialised_states_continue_with_the_same_bits(made):
    fmu, references = opened(made.two, FMU2Slave)
    initialised(fmu)
    names = [references[n] for n in ("where[1]", "where[2]", "where[3]", "momentum")]

    def run(fmu, first, last):
        for k in range(first, last):
            fmu.setReal([references["pull"]], [float(k % 3)])
            fmu.doStep(k * 0.07, 0.07)
        return fmu.getReal(names)

    run(fmu, 0, 6)
    state = fmu.getFMUstate()
    kept = fmu.getReal(names)
    content = fmu.serializeFMUstate(state)
    wanted = run(fmu, 6, 15)
    fmu.setFMUstate(state)
    assert fmu.getReal(names) == kept
    assert run(fmu, 6, 15) == wanted
    fmu.freeFMUstate(state)
    fmu.reset()
    initialised(fmu)
    run(fmu, 0, 6)
    assert run(fmu, 6, 15) == wanted
    fmu.freeInstance()
    other, references = opened(made.two, FMU2Slave)
    initialised(other)
    other.setFMUstate(other.deSerializeFMUstate(content))
    assert run(other, 6, 15) == wanted
    other.freeInstance()


def test_an_input_that_other_parameters_follow(tmp_path):
    """`d` is 2*c: the damper feels a change of `c` in an input twice."""
    (tmp_path / "m.bg").write_text(
        "model M { param c : N*s/m = 3 N*s/m; param d : N*s/m = 2*c;"
        " motion : J1; mass : I(1 kg, f0 = 1 m/s); drag : R(d); motion -> mass, drag; }"
        " scene s of M { observe mass.f; run 1 s; }"
    )
    chosen = ChosenInputs(["c"])
    stages = compile_scene(tmp_path / "m.bg", Options(), prepare=chosen.applied_to)
    program = stages.optimised
    values = {Symbol(Kind.STATE, 0): 1.0, Symbol(Kind.INPUT, 0): 0.5}
    values |= {Symbol(Kind.PARAM, k): value for k, value in enumerate((3.0, 6.0))}
    assert [parameter.name for parameter in program.parameters] == ["c", "d"]
    (state,) = program.states
    assert evaluate_nodes(program.dag, [state.derivative], values) == [-7.0]


def test_an_input_acts_at_its_time(made):
    """A force that the importer switches on at 1.5 s, against a scene that does so."""
    expected = np.asarray(bgc.compile(str(made.folder / "small.bg"), "pulled").simulate()["q"])
    signal = np.array(
        [(0, 0.0), (1.5, 0.0), (1.5, 3.0), (4, 3.0)], dtype=[("time", float), ("pull", float)]
    )
    found = simulate_fmu(
        made.decay,
        fmi_type="ModelExchange",
        input=signal,
        relative_tolerance=1e-10,
        stop_time=4,
        output_interval=1 / 32,
        record_events=False,
    )
    np.testing.assert_allclose(found["q"], expected, atol=1e-7)
    fmu, references = opened(made.decay, FMU2Slave)
    initialised(fmu)
    rows = []
    for k in range(128):
        rows += fmu.getReal([references["q"]])
        fmu.setReal([references["pull"]], [0.0 if k < 48 else 3.0])
        fmu.doStep(k / 32, 1 / 32)
    fmu.freeInstance()
    np.testing.assert_allclose(rows, expected[:-1], atol=1e-8)


def test_parameters_before_the_start_and_during_a_run(made):
    model = bgc.compile(str(made.folder / "small.bg"), "plain")
    model.parameters["k"] = 9.0
    expected = np.asarray(model.simulate()["q"])
    found = simulate_fmu(
        made.decay, fmi_type="CoSimulation", start_values={"k": 9.0}, output_interval=1 / 32
    )
    np.testing.assert_allclose(found["q"], expected, atol=1e-9)
    # Tuned at 1 s: the free vibration from the state there has another frequency.
    fmu, references = opened(made.decay, FMU2Slave)
    initialised(fmu)
    fmu.doStep(0.0, 1.0)
    v, q = fmu.getReal([references["v"], references["q"]])
    fmu.setReal([references["k"]], [25.0])
    fmu.doStep(1.0, 0.7)
    after, work = fmu.getReal([references["q"], references["work"]])
    assert work == pytest.approx(0.5 * (25 - 4) * q**2, rel=1e-8)  # nothing else supplies any
    rate, damping = np.sqrt(25 - 0.0625), 0.25
    t = 0.7
    exact = np.exp(-damping * t) * (
        q * np.cos(rate * t) + (v + damping * q) / rate * np.sin(rate * t)
    )
    assert after == pytest.approx(exact, abs=1e-8)
    with pytest.raises(Exception, match="fmi2SetReal"):
        fmu.setReal([references["v"]], [0.0])
    fmu.freeInstance()


def test_directional_and_adjoint_derivatives_against_differences(made):
    fmu, references = opened(made.three, FMU3Model)
    initialised(fmu)
    fmu.updateDiscreteStates()
    fmu.enterContinuousTimeMode()
    states = ["mass.p", "spring.q", "grip.q", "drop", "fall", "bounces.state", "heading.state"]
    states += ["energy.supplied", "energy.dissipated"]
    inputs = [references["pull"], references["hand.velocity"]]
    knowns = [*(references[n] for n in states), *inputs]
    outputs = ["where", "momentum", "hand.force", "energy.residual"]
    unknowns = [references[n] for n in (*(f"der({n})" for n in states), *outputs)]
    count = fmu.getNumberOfContinuousStates()
    rows = count + 3 + 1 + 3 + 1
    vector = ctypes.c_double * count

    def evaluate(x, u):
        fmu.setContinuousStates(vector(*x), count)
        fmu.setFloat64(inputs, list(u))
        return np.array(fmu.getFloat64(unknowns, nValues=rows))

    start = vector()
    fmu.getContinuousStates(start, count)
    rng = np.random.default_rng(3)
    x0 = np.array(start) + 0.1 * rng.standard_normal(count)
    u0 = np.array([0.4, 0.2, -0.1, 0.3])
    for _ in range(3):
        dx, du = rng.standard_normal(count), rng.standard_normal(4)
        ahead = evaluate(x0 + 1e-6 * dx, u0 + 1e-6 * du)
        difference = (ahead - evaluate(x0 - 1e-6 * dx, u0 - 1e-6 * du)) / 2e-6
        evaluate(x0, u0)
        seed = [*dx, *du]
        found = np.array(fmu.getDirectionalDerivative(unknowns, knowns, seed, nSensitivity=rows))
        np.testing.assert_allclose(found, difference, atol=3e-7)
        weight = rng.standard_normal(rows)
        adjoint = fmu.getAdjointDerivative(unknowns, knowns, list(weight), nSensitivity=len(seed))
        assert np.dot(adjoint, seed) == pytest.approx(weight @ found, rel=1e-12)
    assert abs(found[-1 - 7]) > 0  # `where`, through the algebraic equation
    fmu.freeInstance()


def test_early_return_after_an_intermediate_update(made):
    times = []

    def update(_environment, t, _set, readable, finished, may_return, requested, when):
        assert readable and finished and may_return
        times.append(t)
        if t > 0.3:
            requested[0] = True
            when[0] = t

    fmu, _ = opened(made.three, FMU3Slave, earlyReturnAllowed=True, intermediateUpdate=update)
    initialised(fmu)
    *_, early, last = fmu.doStep(0.0, 1.0)
    assert early and last == times[-1] and 0.3 < last < 1.0 and len(times) > 3
    fmu.freeInstance()


def test_rates_that_are_coupled_are_solved_for(made):
    found = simulate_fmu(
        made.explosion, fmi_type="ModelExchange", stop_time=0.5, relative_tolerance=1e-8
    )
    exact = expm(-0.5 * np.linalg.inv([[2.0, 1.0], [1.0, 3.0]])) @ [1.0, 2.0]
    np.testing.assert_allclose([found["a"][-1], found["b"][-1]], exact, rtol=1e-6)


def test_a_failing_model_reports_an_error_with_its_state(made):
    messages = []
    with pytest.raises(Exception, match="DoStep"):
        simulate_fmu(
            made.explosion,
            fmi_type="CoSimulation",
            stop_time=2,
            output_interval=0.1,
            logger=lambda _environment, name, status, category, message: messages.append(
                (status, message.decode())
            ),
        )
    assert messages and messages[-1][0] == fmpy.fmi2.fmi2Error
    assert "state `size`" in messages[-1][1] and "t = 1.00000" in messages[-1][1]


def test_the_sources_build_as_they_are(made, tmp_path):
    """As an importer builds them: the listed file alone, with strict warnings, same results."""
    folder = Path(fmpy.extract(made.three, unzipdir=str(tmp_path / "x")))
    build = (folder / "sources" / "buildDescription.xml").read_text()
    (source,) = (folder / "sources").glob("*.c")
    assert f'<SourceFile name="{source.name}"/>' in build
    (binary,) = (folder / "binaries").glob("*/*")
    before = simulate_fmu(str(folder), fmi_type="CoSimulation", output_interval=0.125)
    binary.unlink()
    strict = ("-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wdouble-promotion", "-Werror")
    command = ["cc", "-std=c11", "-O0", "-fPIC", "-shared", *strict, source.name]
    subprocess.run([*command, "-o", str(binary), "-lm"], cwd=source.parent, check=True)
    after = simulate_fmu(str(folder), fmi_type="CoSimulation", output_interval=0.125)
    assert np.array_equal(before["where"], after["where"])


def test_files_beside_the_fmu(made):
    """The reference is what the FMU computes; the groups for OSP name all inputs and outputs."""
    folder = made.folder / "decay"
    reference = np.genfromtxt(folder / "small_plain_ref.csv", delimiter=",", names=True)
    lines = (folder / "small_plain_ref.opt").read_text().splitlines()
    options = dict(line.split(", ") for line in lines)
    found = simulate_fmu(
        made.decay,
        fmi_type="CoSimulation",
        stop_time=float(options["StopTime"]),
        output_interval=float(options["StepSize"]),
    )
    np.testing.assert_allclose(found["q"], reference["q"], atol=1e-9)
    assert (folder / "small_plain_in.csv").read_text() == '"time","pull"\n0.0,0.0\n4.0,0.0\n'
    groups = ElementTree.parse(made.folder / "two" / "everything_s_OspModelDescription.xml")
    space = "{https://open-simulation-platform.com/OspModelDescription/1.0.0}"
    members = {
        group.get("name"): [v.get("ref") for v in group] for group in groups.iter(f"{space}Generic")
    }
    assert members["hand.velocity"] == [f"hand.velocity[{k}]" for k in (1, 2, 3)]
    assert {"pull", "where", "hand.force", "energy.residual"} <= members.keys()


def refused(arguments: list[str]) -> str:
    result = CliRunner().invoke(application, ["build", *arguments])
    assert result.exit_code != 0
    assert result.exception is None or isinstance(result.exception, (BgError, SystemExit))
    return result.output + str(result.exception)


def test_refusals(made, tmp_path, monkeypatch):
    small = str(made.folder / "small.bg")
    fmu = [small, "--scene", "plain", "--target", "fmu2", "-o", str(tmp_path)]
    assert "BG750" in refused([*fmu, "--platforms", "linux"])
    assert "BG753" in refused(
        [small, "--scene", "foreign", "--target", "fmu2", "-o", str(tmp_path)]
    )
    assert "--platforms needs" in refused([small, "--platforms", "win64"])
    other = next(name for name in PLATFORMS if name != host_platform())
    monkeypatch.setattr(binaries, "find_spec", lambda name: None)
    assert "BG751" in refused([*fmu, "--platforms", other])
    with monkeypatch.context() as patch:
        patch.setattr(binaries, "_FLAGS", ("-no-such-flag",))
        assert "BG752" in refused(fmu)
    with monkeypatch.context() as patch:
        full = OSError(errno.ENOSPC, "No space left on device")
        patch.setattr(Cache, "publish", Mock(side_effect=full))
        patch.setattr(binaries, "find_toolchain", lambda: Toolchain(("cc",), "gcc", ""))
        assert "BG055" in refused(fmu)
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "taken").write_text("a file")
    monkeypatch.setattr(binaries, "_FLAGS", ("-std=c11", "-O0", "-fPIC", "-fvisibility=hidden"))
    assert "BG055" in refused([*fmu[:-1], str(tmp_path / "taken" / "inside")])
