"""The commands on real models, through the whole compiler."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from model_files import model_text
from own_caches import with_runtime

from bgc.building.toolchain import find_toolchain
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.cli.app import application
from bgc.runtime.compiling import compile_model

RC = model_text("commands_rc")


TRACED = model_text("commands_traced")


@pytest.fixture(scope="module")
def cache(tmp_path_factory) -> Path:
    return with_runtime(tmp_path_factory.mktemp("cache"))


@pytest.fixture
def rc(cache, monkeypatch, tmp_path) -> Path:
    monkeypatch.setenv("BGC_CACHE_DIR", str(cache))
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "rc.bg"
    path.write_text(RC)
    return path


def bgc(*arguments: object) -> Result:
    return CliRunner().invoke(application, [str(argument) for argument in arguments])


def voltages(result: Result) -> list[float]:
    return [float(line.split(",")[1]) for line in result.stdout.splitlines()[1:]]


def test_run_writes_what_the_scene_observes(rc):
    result = bgc("run", rc, "--out", "-", "--rtol", "1e-10")
    assert result.exit_code == 0, result.stderr
    assert result.stdout.splitlines()[0] == "time,voltage,current"
    expected = 5 * (1 - np.exp(-np.array([0.0, 2.0, 4.0, 6.0]) / 6))
    assert voltages(result) == pytest.approx(expected, rel=1e-8)


def test_run_draws_what_the_scene_plots(rc):
    assert bgc("run", rc, "--plot", "p.svg").exit_code == 0
    assert Path("p.svg").read_text().count("voltage [V]") == 2  # an axis of each panel


def test_run_takes_another_scene(rc):
    result = bgc("run", rc, "--scene", "fixed", "--out", "-")
    assert len(result.stdout.splitlines()) == 1002
    assert bgc("run", rc, "--scene", "nothing").exit_code == 1


def test_set_changes_a_parameter_without_compiling(rc, monkeypatch):
    bgc("run", rc)
    monkeypatch.setattr("bgc.driver.compile_scene", None)  # whoever calls it fails
    result = bgc("run", rc, "--out", "-", "--set", "R=1 kohm", "--rtol", "1e-10")
    assert result.exit_code == 0, result.stderr
    assert voltages(result)[-1] == pytest.approx(5 * (1 - np.exp(-6 / 3000)), rel=1e-7)


def test_set_outside_the_range_or_of_no_parameter(rc):
    assert "error[BG061]" in bgc("run", rc, "--set", "C=11 F").stderr
    result = bgc("run", rc, "--set", "X=1")
    assert result.exit_code == 1
    assert "error[BG" in result.stderr and "`X`" in result.stderr


def test_a_changed_file_is_compiled_again(rc):
    first = voltages(bgc("run", rc, "--out", "-"))[-1]
    rc.write_text(RC.replace("e = 5 V", "e = 10 V"))
    assert voltages(bgc("run", rc, "--out", "-"))[-1] == pytest.approx(2 * first)


def test_build_makes_one_c_file_that_any_compiler_takes(rc):
    assert bgc("build", rc, "--target", "c", "-o", "out/own.c").stdout == "out/own.c\n"
    result = bgc("build", rc, "--target", "c", "-o", "out/deep")
    assert result.stdout.split() == ["out/deep/rc.c"]
    strict = (
        "-std=c11",
        "-Wall",
        "-Wextra",
        "-Wconversion",
        "-Wpedantic",
        "-Wdouble-promotion",
        "-Werror",
    )
    command = [*find_toolchain().command, *strict, "-fsyntax-only", "out/deep/rc.c"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_build_makes_a_shared_object_and_tells_the_time(rc):
    result = bgc("build", rc, "--scene", "charge", "--timings")
    assert result.stdout.split() == ["rc.charge.so"]
    assert "together" in result.stderr
    assert Path("rc.charge.so").stat().st_size > 1000


def test_check_counts_and_names_what_is_wrong(rc):
    assert bgc("check", rc).exit_code == 0
    wrong = rc.with_name("wrong.bg")
    wrong.write_text(RC.replace("R(R)", "Q(R)").replace("6 s every 2 s", "-1 s"))
    result = bgc("check", rc, wrong, rc.with_name("missing.bg"))
    assert result.exit_code == 1
    assert "wrong.bg:9:" in result.stderr
    assert "missing.bg" in result.stderr
    assert "3 files: " in result.stderr


@pytest.mark.parametrize(
    ("name", "part"),
    [("parse", "Model"), ("causality", "|->"), ("equations", "capacitor.q'"), ("emit", "bgc_")],
)
def test_show_prints_passes(rc, name, part):
    result = bgc("show", rc, "--after", name)
    assert result.exit_code == 0, result.stderr
    assert part in result.stdout


def test_show_names_the_passes_there_are(rc):
    result = bgc("show", rc, "--after", "magic")
    assert result.exit_code == 2
    assert "causality" in result.stderr


@pytest.mark.skipif(shutil.which("dot") is None, reason="needs Graphviz")
def test_graph_draws(rc):
    assert bgc("graph", rc).stdout.split() == ["rc.svg"]
    assert "capacitor" in Path("rc.svg").read_text()
    assert bgc("graph", rc, "-o", "g.dot").exit_code == 0
    assert Path("g.dot").read_text().startswith("digraph")
    assert bgc("graph", rc, "-o", "g.jpg").exit_code == 1


def test_fmt_formats_once(rc):
    rc.write_text(RC.replace("  supply    :", "     supply   :"))
    assert bgc("fmt", rc, "--check").exit_code == 1
    assert bgc("fmt", rc).exit_code == 0
    assert rc.read_text() == RC
    assert bgc("fmt", rc, "--check").exit_code == 0
    rc.write_text("model {")
    assert bgc("fmt", rc).exit_code == 1
    assert rc.read_text() == "model {"


def test_an_unwritable_cache_is_a_warning(rc, monkeypatch):
    monkeypatch.setenv("BGC_CACHE_DIR", str(rc / "below_a_file"))
    result = bgc("run", rc)
    assert result.exit_code == 0
    assert "warning[BG054]" in result.stderr


def test_c_goes_to_standard_output_and_a_shared_object_does_not(rc):
    result = bgc("build", rc, "--target", "c", "-o", "-")
    assert result.exit_code == 0
    assert result.stdout.startswith("/*") and result.stdout.endswith("\n")
    assert "bgc_get_model" in result.stdout
    assert bgc("build", rc, "-o", "-").exit_code == 2
    assert not Path("-").exists()


@pytest.mark.skipif(sys.platform != "linux", reason="other systems refuse such names")
def test_a_name_that_is_not_utf8_is_shown_with_its_bytes(rc):
    name = os.fsdecode(b"r\xff.bg")
    result = bgc("run", name)
    assert result.exit_code == 1
    assert "r\\xff.bg" in result.stderr
    Path(name).write_text(RC)
    assert bgc("run", name).exit_code == 0
    result = bgc("build", name)
    assert result.exit_code == 0
    assert result.stdout_bytes == b"r\xff.so\n"


def test_a_binary_file_of_a_device_leaves_the_terminal_alone(rc):
    Path("motion.csv").write_bytes(b"time,x,y,z\n\x1b[31m\xff\x07" + b"\x01" * 400 + b",0,0,0\n")
    rc.write_text(TRACED)
    result = bgc("run", rc)
    assert result.exit_code == 1
    (line, *_) = result.stderr.splitlines()
    assert "error[BG074]" in line and "motion.csv:2: there is no number in the column time" in line
    assert line.isprintable() and len(line) < 400


def test_no_compiler_is_a_diagnostic(rc, monkeypatch, tmp_path):
    monkeypatch.setenv("BGC_CACHE_DIR", str(tmp_path / "empty"))
    monkeypatch.setenv("CC", "no-such-compiler")
    result = bgc("run", rc)
    assert result.exit_code == 1
    assert "error[BG051]" in result.stderr


def test_vectors_are_set_as_one_or_by_component(rc):
    rc.write_text(
        "model M { param a[2] : m = [1 m, 2 m]; param K[2, 2] = [[1, 2], [3, 4]];\n"
        "  state x = 0; der(x) = a[1] + a[2] + K[1, 2]; }\n"
        "scene s of M { observe x; run 1 s; }\n"
    )
    model = compile_model(rc, parameters={"a": ["1 km", 0], "K[1,2]": 7})
    assert [p.value for p in model.parameters.values()] == [1000, 0, 1, 7, 3, 4]
    assert model.simulate()["x"][-1] == pytest.approx(1007)
    model.parameters["K"] = np.zeros((2, 2))
    assert model.simulate()["x"][-1] == pytest.approx(1000)
    del model.parameters["a"]
    assert model.simulate()["x"][-1] == pytest.approx(3)
    for name, value in (("a", [1, 2, 3]), ("K", [1, 2, 3, 4]), ("a[1]", [1.0])):
        with pytest.raises(BgError) as error:
            model.parameters[name] = value
        assert error.value.diagnostics[0].code == "BG077"


def test_a_vector_as_text_is_compiled_in(rc):
    rc.write_text(
        "model M { param a[2] = [1, 2]; state x = 0; der(x) = a[1] + a[2]; }\n"
        "scene s of M { observe x; run 1 s; }\n"
    )
    result = bgc("run", rc, "--set", "a=[3, 4]", "--out", "-")
    assert voltages(result)[-1] == pytest.approx(7)


# --- explanations -----------------------------------------------------------------------------


def test_causality_tells_strokes_and_storage(rc):
    result = bgc("causality", rc)
    assert result.exit_code == 0, result.stderr
    assert "`resistor` takes the effort it is given" in result.stdout
    assert "capacitor  C     integral   capacitor.q" in result.stdout
    assert result.stdout == bgc("show", rc, "--after", "causality").stdout


def test_strokes_are_told_even_where_the_equations_cannot_be_derived(rc):
    rc.write_text(RC.replace("Se(e = 5 V)", "Se(e = loop.f*R)"))
    result = bgc("causality", rc)
    assert result.exit_code == 1
    assert "loop |-> capacitor" in result.stdout and "error[BG520]" in result.stderr


def test_equations_as_text_and_as_latex(rc):
    assert "capacitor.q' = " in bgc("equations", rc).stdout
    latex = bgc("equations", rc, "--latex").stdout
    assert r"\dot{q}_{\mathrm{capacitor}} &= " in latex and latex.count(r"\begin{align*}") == 2


def test_linear_equations_and_their_modes(rc):
    result = bgc("equations", rc, "--linear", "--input", "supply.e", "--out", "lin.csv")
    assert result.exit_code == 0, result.stderr
    assert "time constant s" in result.stdout
    a, b = (float(x) for x in Path("lin.csv").read_text().splitlines()[1].split(",")[1:])
    assert (a, b) == (pytest.approx(-1 / 6), 0.5)
    steady = bgc("equations", rc, "--linear", "--steady")
    assert "capacitor.q  15 " in steady.stdout
    assert "at 6 s" in bgc("equations", rc, "--linear", "--at", "6 s").stdout


def test_a_transfer_function_in_the_models_letters(rc):
    result = bgc("equations", rc, "--transfer", "voltage/supply.e", "--set", "R=4 ohm")
    assert result.exit_code == 0, result.stderr
    assert result.stdout.splitlines()[:5] == [
        "voltage by supply.e",
        "",
        "             1",
        "  G(s) = ---------",
        "         R*C*s + 1",
    ]
    assert "-1/(C*R)" in result.stdout and "-0.0833333" in result.stdout  # -1/(3 F * 4 ohm)
    latex = bgc("equations", rc, "--transfer", "current/supply.e", "--latex")
    assert r"G(s) &= \frac{C\,s}{R\,C\,s + 1}" in latex.stdout
    assert r"p_{1} &= - \frac{1}{C\,R} \approx -0.166667" in latex.stdout


def test_several_transfer_functions_of_any_expressions(rc):
    pairs = ("--transfer", "capacitor.e/2/supply.e", "--transfer", "current / R")
    result = bgc("equations", rc, *pairs)
    assert result.exit_code == 0, result.stderr
    assert "capacitor.e/2 by supply.e" in result.stdout and "current by R" in result.stdout
    assert "capacitor.q" in result.stdout  # the state stands in the second as a letter
    steady = bgc("equations", rc, "--transfer", "current/R", "--steady").stdout
    assert "  capacitor.q  15 " in steady


def test_bode_writes_rows_and_a_plot(rc):
    names = ("--input", "supply.e", "--output", "voltage")
    result = bgc("bode", rc, *names, "--out", "-", "--plot", "b.svg", "--from", "0.01", "--to", "9")
    assert result.exit_code == 0, result.stderr
    header, *lines = result.stdout.splitlines()
    assert header == "omega,magnitude_db,phase_deg,real,imag"
    rows = np.array([[float(x) for x in line.split(",")] for line in lines])
    exact = 1 / (6j * rows[:, 0] + 1)
    np.testing.assert_allclose(rows[:, 3] + 1j * rows[:, 4], exact, rtol=1e-12)
    np.testing.assert_allclose(rows[:, 2], np.rad2deg(np.angle(exact)), rtol=1e-12)
    assert "phase [deg]" in Path("b.svg").read_text()
    assert "magnitude dB" in bgc("bode", rc, *names).stdout


def test_bode_has_a_curve_for_each_pair_that_responds(rc):
    rc.write_text(TWO_BODIES)
    result = bgc("bode", rc, "--input", "push.e", "--output", "v", "--out", "-", "--plot", "b.svg")
    header, *lines = result.stdout.splitlines()
    assert header == "output,input,omega,magnitude_db,phase_deg,real,imag"
    assert {tuple(line.split(",")[:2]) for line in lines} == {
        ("v[1]", "push.e[1]"),
        ("v[2]", "push.e[2]"),
    }
    assert "v[2] by push.e[2]" in Path("b.svg").read_text()
    assert bgc("bode", rc, "--input", "push.e[1]", "--output", "v[2]").exit_code == 1


TWO_BODIES = """
    model M {
      push : Se[2](e = [1, 2]); hub : J1; body : I[2](1 kg); drag : R[2](1);
      push -> hub -> body, drag;
    }
    scene s of M { observe body.f as v; run 1 s; }
"""


@pytest.mark.parametrize("command", ["margins", "poles", "locus"])
def test_a_loop_has_one_input_and_one_output(rc, command):
    rc.write_text(TWO_BODIES)
    for names in (("push.e", "v[1]"), ("push.e[1]", "v")):
        result = bgc(command, rc, "--input", names[0], "--output", names[1])
        assert result.exit_code == 1 and "error[BG084]" in result.stderr
    assert bgc(command, rc, "--input", "push.e[2]", "--output", "v[2]").exit_code == 0


def test_linear_commands_print_and_draw(rc):
    """The circuit is 1/(6 s + 1)."""
    names = ("--input", "supply.e", "--output", "voltage")
    found = bgc("modes", rc, "--out", "m.csv", "--plot", "m.png").stdout
    assert "-0.166667" in found and Path("m.csv").read_text().startswith("real,imag,period")
    assert "-0.166667" in bgc("poles", rc, *names, "--plot", "p.png").stdout
    found = bgc("poles", rc, *names, "--gain", "5", "--closed").stdout
    assert "-1\n" in found and "0.833333" in found
    found = bgc("margins", rc, *names, "--gain", "2", "--nyquist", "n.png", "--nichols", "o.png")
    assert "the closed loop is stable" in found.stdout and "120 deg" in found.stdout
    found = bgc("step", rc, *names, "--time", "12 s", "--out", "s.csv", "--plot", "s.png").stdout
    assert "0.864665" in found  # 1 - exp(-2)
    assert Path("s.csv").read_text().startswith("time,voltage")
    found = bgc("locus", rc, *names, "--out", "l.csv", "--plot", "l.png").stdout
    assert "no pole crosses" in found
    assert len(list(Path().glob("*.png"))) == 6


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["step", "--output", "voltage", "--time", "0 s"], "BG797"),
        (["step", "--output", "supply.e", "--gain", "-1", "--closed"], "BG795"),
        (["margins", "--output", "voltage", "--gain", "2 N"], "BG063"),
        (["step", "--output", "voltage", "--gain", "-9", "--closed", "--time", "1e9 s"], "BG798"),
        (["poles", "--output", "voltage", "--gain", "1e300", "--closed"], "BG798"),
        (["bode", "--output", "voltage", "--gain", "1e308"], "BG798"),
        (["locus", "--output", "voltage", "--gain", "1e-300"], "BG798"),
        (["equations", "--transfer", "voltage"], "BG098"),
        (["equations", "--transfer", "voltage/"], "BG098"),
        (["equations", "--transfer", "voltage/suply.e"], "BG080"),
        (["equations", "--transfer", "nothing/supply.e"], "BG211"),
    ],
)
def test_linear_commands_refuse(rc, arguments, code):
    source = ("--input", "supply.e") if "--transfer" not in arguments else ()
    result = bgc(arguments[0], rc, *source, *arguments[1:])
    assert result.exit_code == 1 and f"error[{code}]" in result.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        ["equations", "--latex", "--linear"],
        ["equations", "--steady"],
        ["equations", "--linear", "--transfer", "voltage/supply.e"],
        ["equations", "--transfer", "voltage/supply.e", "--input", "supply.e"],
        ["equations", "--linear", "--steady", "--at", "1 s"],
        ["bode", "--input", "R"],
    ],
)
def test_explanations_asked_for_wrongly(rc, arguments):
    assert bgc(arguments[0], rc, *arguments[1:]).exit_code == 2
