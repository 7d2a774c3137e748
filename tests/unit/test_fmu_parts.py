"""FMUs as parts of a scene: own ones against the one model, foreign ones against exact steps."""

from __future__ import annotations

from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest
from click.testing import CliRunner, Result
from fmpy import simulate_fmu
from foreign_fmus import LAG, WHOLE, foreign_fmu

import bgc
from bgc.building.platforms import host_platform
from bgc.diagnostics.diagnostic import BgError
from bgc.grammar.format import format_source
from bgc.grammar.source_files import read_source
from bgc.runtime.cli.app import application
from bgc.runtime.fmi import binaries
from bgc.runtime.running.failures import SimulationError
from bgc.runtime.running.run import choose_method
from bgc.runtime.view.live import LiveRun

pytestmark = pytest.mark.skipif(host_platform() != "linux64", reason="FMUs of 64-bit Linux on x86")

BODY = """model Body {
  param m = 2 kg;
  input push : N = 0 N;
  force : MSe(e = push);
  j : J1;
  mass : I(m, f0 = 0.5 m/s);
  damper : R(3 N*s/m);
  force -> j;
  j -> mass, damper;
}
scene body of Body {
  observe mass.f as speed in km/h;
  solver rodas5p(rtol = 1e-9);
  run 2 s every 10 ms;
}
"""
PAIR = """import "body_fmu.bg";
model Own { port tip in; j : J1; mass : I(2 kg, f0 = 0.5 m/s); damper : R(3 N*s/m);
  tip -> j -> mass, damper; }
model Driven[n] {
  drive : Sf(f = 1 m/s);
  gap : J0;
  spring : C(stiffness = 400 N/m);
  drive -> gap -> spring;
  if n == 1 {
    load : Own;
    gap -> load.tip;
  } else {
    load : Body;
    gap -> load.tip;
  }
}
scene one of Driven[1] { observe spring.e, load.mass.f as speed; solver rodas5p(rtol = 1e-9);
  run 2 s every 10 ms; }
scene two of Driven[2] { observe spring.e, load.speed as speed; solver rodas5p(rtol = 1e-9);
  run 2 s every 10 ms; }
"""
LAG_SCENE = """import "lag.bg";
model Driven {
  param level = 3 kN;
  lag : Lag(u = if time < 0.5 s then level else -1 kN, is_on = 1);
  output force : N = lag.x;
}
scene s of Driven {
  observe force, lag.steps as steps, lag.x as same in kN;
  run 2 s every 0.1 s;
}
"""


def run(*arguments: object) -> Result:
    return CliRunner().invoke(application, [str(argument) for argument in arguments])


def imported(path: Path, *options: str) -> Path:
    """Import an FMU beside itself, as its stem with `_fmu`."""
    goal = path.with_name(f"{path.stem}_fmu{options[-1]}.bg" if options else f"{path.stem}.bg")
    result = run("import", path, "-o", goal, "--force", *options)
    assert result.exit_code == 0, result.output
    text = goal.read_text()
    assert format_source(read_source(goal)) == text
    return goal


@pytest.fixture(scope="module")
def bodies(tmp_path_factory) -> dict[int, Path]:
    """FMUs of `BODY` in both versions, each with its import and the scenes of `PAIR`."""
    made = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(binaries, "_FLAGS", ("-std=c11", "-O0", "-fPIC", "-fvisibility=hidden"))
        for version in (2, 3):
            folder = tmp_path_factory.mktemp(f"bodies{version}")
            (folder / "body.bg").write_text(BODY)
            built = run("build", folder / "body.bg", "--target", f"fmu{version}", "--input", "push",
                        "-o", folder / "body.fmu")  # fmt: skip
            assert built.exit_code == 0, built.output
            for order in "12":
                imported(folder / "body.fmu", "--power", "tip=push,speed", "--order", order)
                (folder / f"pair{order}.bg").write_text(
                    PAIR.replace("body_fmu.bg", f"body_fmu{order}.bg")
                )
            made[version] = folder
    return made


@pytest.mark.parametrize(("version", "order"), [(2, 1), (3, 1), (3, 2)])
def test_an_fmu_of_ours_equals_the_one_model_as_the_step_goes_to_zero(bodies, version, order):
    file = bodies[version] / f"pair{order}.bg"
    one = bgc.compile(file, "one").simulate()
    two = bgc.compile(file, "two")
    steps = np.array([10.0, 5.0, 2.5])
    runs = [two.simulate(parameters={"load.step": f"{step} ms"}) for step in steps]
    for name in ("spring.e", "speed"):
        exact = np.asarray(one[name])
        off = np.array([np.abs(np.asarray(r[name]) - exact).max() for r in runs])
        np.testing.assert_allclose(np.log2(off[:-1] / off[1:]), order, atol=0.2)
        assert off[0] < 0.04 * np.abs(exact).max()


@pytest.mark.parametrize("version", [2, 3])
def test_an_fmu_in_a_scene_is_that_of_fmpy(bodies, version):
    """FMPy gives an FMU the input of the beginning of a step, a scene that of its end."""
    folder, step = bodies[version], 0.01
    scene = 'import "body_alone.bg";\nmodel M { b : Body(push = 3 N * sin(4*time/1 s)); }\n'
    scene += "scene s of M { observe b.speed as speed; run 1 s every 10 ms; }\n"
    assert run("import", folder / "body.fmu", "-o", folder / "body_alone.bg").exit_code == 0
    (folder / "alone.bg").write_text(scene)
    result = bgc.compile(folder / "alone.bg").simulate(parameters={"b.m": "1.5 kg"})
    times = np.arange(102) * step
    given = np.array(
        list(zip(times, 3 * np.sin(4 * (times + step)), strict=True)),
        dtype=[("time", float), ("push", float)],
    )
    judged = simulate_fmu(
        str(folder / "body.fmu"),
        fmi_type="CoSimulation",
        start_values={"m": 1.5},
        input=given,
        output=["speed"],
        stop_time=1,
        step_size=step,
        output_interval=step,
    )
    np.testing.assert_allclose(np.asarray(result["speed"]), judged["speed"] / 3.6, atol=1e-9)


@pytest.fixture(scope="module")
def lag(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("lag")
    imported(foreign_fmu(folder / "lag.fmu"))
    (folder / "scene.bg").write_text(LAG_SCENE)
    return folder


def exact_lag(step: float, rows: int, gain: float = 2.0, T: float = 0.5) -> np.ndarray:
    """x at each tenth of a second, with the input at the end of each step."""
    x, found = 0.0, [0.0]
    per = round(0.1 / step)
    for k in range(1, (rows - 1) * per + 1):
        u = 3000.0 if k * step < 0.5 - 1e-9 else -1000.0
        x = gain * u + (x - gain * u) * np.exp(-step / T)
        if k % per == 0:
            found.append(x)
    return np.array(found)


def test_a_foreign_fmu_takes_exact_steps_in_its_own_units(lag):
    model = bgc.compile(lag / "scene.bg")
    result = model.simulate()
    np.testing.assert_allclose(result["force"], exact_lag(0.01, 21), rtol=1e-12)
    np.testing.assert_allclose(np.asarray(result["same [kN]"]) * 1000, result["force"], rtol=1e-12)
    np.testing.assert_array_equal(result["steps"], np.arange(21) * 10)
    changed = model.simulate(parameters={"lag.gain": 5, "lag.T": "0.2 s", "lag.step": "20 ms"})
    np.testing.assert_allclose(changed["force"], exact_lag(0.02, 21, 5.0, 0.2), rtol=1e-12)
    again = model.simulate()  # an instance of its own
    np.testing.assert_array_equal(again["force"], result["force"])


def test_arrays_and_numbers_of_all_types(tmp_path):
    imported(foreign_fmu(tmp_path / "lags.fmu", 3))
    given = ", ".join(f"set{kind} = -7.2" for kind in WHOLE)
    (tmp_path / "scene.bg").write_text(
        f'import "lags.bg";\nmodel M {{ l : Lags(u = [4, 5], on = 1, {given}); }}\n'
        "scene s of M { observe l.x, l.rough, l.getInt16 as whole; run 0.5 s every 0.1 s; }\n"
    )
    result = bgc.compile(tmp_path / "scene.bg").simulate(parameters={"l.gain": [1, 3]})
    decayed = 1 - np.exp(-0.5 / 0.5)
    for k, level in enumerate((4.0, 15.0), 1):
        assert np.asarray(result[f"l.x[{k}]"])[-1] == pytest.approx(level * decayed, rel=1e-12)
        assert np.asarray(result[f"l.rough[{k}]"])[-1] == pytest.approx(level * decayed, rel=1e-6)
    assert np.asarray(result["whole"])[-1] == -7
    for T, why in ((99.0, "lags: no step"), (77.0, "asks to end")):
        with pytest.raises(BgError, match=why):
            bgc.compile(tmp_path / "scene.bg").simulate(parameters={"l.T": T})


def test_a_failed_step_ends_the_run_with_its_rows(lag, tmp_path):
    table = tmp_path / "rows.csv"
    ended = run("run", lag / "scene.bg", "--set", "lag.gain=99", "--out", table)
    assert ended.exit_code == 1
    assert "BG673" in ended.stderr and "lag: no step of 7" in ended.stderr
    assert table.read_text().splitlines()[-1].startswith("1.0,")
    model = bgc.compile(lag / "scene.bg")
    with pytest.raises(SimulationError, match="fmi2DoStep returned Fatal"):
        model.simulate(parameters={"lag.gain": 98})
    np.testing.assert_allclose(model.simulate()["force"], exact_lag(0.01, 21), rtol=1e-12)


def test_ensembles_have_an_instance_each(lag, tmp_path):
    for name, flags in (("many", ()), ("once", ("-DONCE",))):
        folder = tmp_path / name
        folder.mkdir()
        once = 'canBeInstantiatedOnlyOncePerProcess="true" ' if flags else ""
        text = LAG.replace("<CoSimulation ", f"<CoSimulation {once}")
        imported(foreign_fmu(folder / "lag.fmu", 2, flags, text))
        (folder / "scene.bg").write_text(LAG_SCENE)
        model = bgc.compile(folder / "scene.bg")
        kept = [model.simulate(parameters={"lag.gain": gain})["force"] for gain in (1, 2, 3)]
        found = model.sweep({"lag.gain": [1, 2, 3]})
        np.testing.assert_array_equal(np.asarray(found["force"]), np.array(kept))


def test_a_parameter_that_changes_in_a_live_run_keeps_the_fmu(lag):
    model = bgc.compile(lag / "scene.bg")
    live = LiveRun(model, choose_method(model.library, model.facts), {})
    live.reset()
    live.advance(np.array([0.3]))
    live.set_parameter("level", 5000.0)
    live.set_parameter("lag.T", 0.25)
    rows, fault = live.advance(np.array([0.4]))
    assert fault is None
    x = exact_lag(0.01, 4)[-1]
    x = 2 * 5000 + (x - 2 * 5000) * np.exp(-0.1 / 0.25)
    assert rows[-1][0] == pytest.approx(x, rel=1e-9)


def test_binaries_that_do_not_serve(tmp_path):
    text = 'model M { sample 1 s { signal y = fmu("a.fmu", "x"); } output z = y; }\n'
    (tmp_path / "scene.bg").write_text(f"{text}scene s of M {{ observe z; run 2 s; }}\n")

    def refused(entries: dict[str, bytes]) -> str:
        with ZipFile(tmp_path / "a.fmu", "w") as archive:
            archive.writestr("modelDescription.xml", LAG)
            for name, content in entries.items():
                archive.writestr(name, content)
        assert run("import", tmp_path / "a.fmu", "-o", "-").exit_code == 0
        return run("run", tmp_path / "scene.bg").stderr

    windows = refused({"binaries/win64/lag.dll": b"MZ"})
    assert "BG671" in windows and "linux64" in windows and "win64" in windows
    assert "BG671" in refused({})
    assert "BG672" in refused({"binaries/linux64/lag.so": b"no library"})


def test_exports_and_starts_that_cannot_hold_it(lag, tmp_path):
    scene = lag / "scene.bg"
    for target in ("fmu2", "ssp"):
        assert "BG674" in run("build", scene, "--target", target, "-o", tmp_path).stderr
    (lag / "rest.bg").write_text(LAG_SCENE.replace("run 2 s", "start rest; run 2 s"))
    assert "BG674" in run("run", lag / "rest.bg").stderr
    assert "BG784" in run("run", scene, "--sensitivities", "level").stderr
    made = run("build", scene, "--target", "c", "-o", tmp_path)
    assert made.exit_code == 0 and "bgc_open_fmu" in Path(made.output.strip()).read_text()
    assert "x -> lag.values[1]" in run("show", scene, "--after", "equations").output


def test_an_instance_that_was_taken_back_is_refused(lag):
    model = bgc.compile(lag / "scene.bg")
    with model.started(choose_method(model.library, model.facts), False) as instance:
        saved = instance.save()
        rows = np.empty((1, model.row_width))
        instance.run(np.array([0.5]), rows)
        instance.restore(saved)
        status, _ = instance.run(np.array([0.5]), rows)
        assert "taken back" in str(model.explain(instance, status))


@pytest.mark.parametrize(
    ("options", "what"),
    [
        (["--power", "tip=u"], "PORT=EFFORT,FLOW"),
        (["--power", "tip=u,nothing"], "nothing"),
        (["--power", "tip=x,steps"], "an input and an output"),
    ],
)
def test_power_ports_that_are_no_pair(lag, options, what):
    refused = run("import", lag / "lag.fmu", "-o", "-", *options)
    assert refused.exit_code != 0 and what in refused.output + str(refused.exception)


@pytest.mark.parametrize(
    ("change", "what"),
    [
        (('fmiVersion="2.0"', 'fmiVersion="1.0"'), "FMI 1.0"),
        (("<CoSimulation", "<ModelExchange"), "no Co-Simulation"),
        (("<UnitDef", "<!DOCTYPE a><UnitDef"), "document type"),
        (("</fmiModelDescription>", ""), "not well-formed"),
        (('modelIdentifier="lag"', 'modelIdentifier="../lag"'), "letters and digits"),
        (('causality="output"', 'causality="local"'), "no outputs"),
    ],
)
def test_fmus_that_are_not_read(tmp_path, change, what):
    with ZipFile(tmp_path / "bad.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", LAG.replace(*change))
    refused = run("import", tmp_path / "bad.fmu", "-o", "-")
    assert refused.exit_code == 1 and "BG137" in refused.stderr and what in refused.stderr


def test_what_a_text_cannot_hold_is_left_out(tmp_path):
    text = LAG.replace('name="odd"', 'name="a &quot;b&quot;"').replace('start="0.5"', 'start="NaN"')
    with ZipFile(tmp_path / "odd.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", text.replace('factor="1000"', 'factor="INF"'))
    result = run("import", tmp_path / "odd.fmu", "-o", "-")
    assert result.exit_code == 0 and "BG139" in result.stderr
    assert "param T : s = 0 s;" in result.stdout and "input u : N = 0 N;" in result.stdout
    assert "&quot;" not in result.stdout and '\\"' not in result.stdout


def test_files_that_are_no_fmus(tmp_path):
    (tmp_path / "text.fmu").write_text("no archive")
    with ZipFile(tmp_path / "empty.fmu", "w"):
        pass
    for name, what in (
        ("text", "zip archive"),
        ("empty", "modelDescription"),
        ("none", "none.fmu"),
    ):
        refused = run("import", tmp_path / f"{name}.fmu", "-o", "-")
        assert refused.exit_code == 1 and what in refused.stderr


CALL = 'fmu("lag.fmu", ["x", "steps"], "gain", 3, "u", 2 N)'


@pytest.mark.parametrize(
    ("call", "code"),
    [
        (CALL.replace("lag.fmu", "none.fmu"), "BG273"),
        (CALL.replace("lag.fmu", "scene.bg"), "BG273"),
        ("1 + " + CALL, "BG274"),
        (CALL.replace('"u", 2 N', '"u"'), "BG274"),
        (CALL.replace('["x", "steps"]', '["x"]'), "BG274"),
        (CALL.replace('"steps"', "2"), "BG274"),
        (CALL.replace('"steps"', '"stepss"'), "BG275"),
        (CALL.replace('"steps"', '"label"'), "BG276"),
        (CALL.replace('"steps"', '"gain"'), "BG276"),
        (CALL.replace('"u", 2 N', '"x", 2 N'), "BG276"),
        (CALL.replace('"u", 2 N', '"gain", 2'), "BG220"),
        (CALL.replace("2 N", "2 m"), "BG306"),
        (CALL.replace('"gain", 3', '"gain", time/1 s'), "BG332"),
    ],
)
def test_calls_that_are_refused(lag, call, code):
    text = f"model M {{ sample 1 s {{ signal y[2] = {call}; }} output z = y[2]; }}\n"
    (lag / "call.bg").write_text(f"{text}scene s of M {{ observe z; run 2 s; }}\n")
    with pytest.raises(BgError) as refused:
        bgc.compile(lag / "call.bg")
    assert {each.code for each in refused.value.diagnostics} == {code}, refused.value
