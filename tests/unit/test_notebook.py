"""The Python interface in scripts and notebooks: quantities, views, exports, short errors."""

import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from IPython.core.interactiveshell import InteractiveShell

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.library import __path__ as library_path
from bgc.runtime.linear.state_space import Linearisation
from bgc.runtime.trade.trade import trade

README = Path(__file__).parents[2] / "README.md"
MODEL = README.read_text("utf-8").split("```bg\n")[1].split("```")[0]
NOTEBOOK = Path(next(iter(library_path))) / "examples/series_circuit.ipynb"


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    found = tmp_path_factory.mktemp("notebook") / "rlc.bg"
    found.write_text(MODEL)
    return found


@pytest.fixture(scope="module")
def model(path):
    return bgc.compile(path)


@pytest.fixture(scope="module")
def result(model):
    return model.simulate()


def code_of(call, *arguments, **named):
    with pytest.raises(BgError) as caught:
        call(*arguments, **named)
    return caught.value.diagnostics[0].code


def test_dir_lists_what_a_user_imports():
    assert {"compile", "trade", "Model", "Result", "BgError"} <= set(dir(bgc))
    assert not [name for name in dir(bgc) if name.startswith("_H")]


# --- quantities -----------------------------------------------------------------------------


def test_texts_with_units_are_quantities_everywhere(model, result):
    same = model.simulate("10 ms", every="10 us", rtol="1e-6", max_step="1 ms")
    assert same["loop.f"] == pytest.approx(result["loop.f"], rel=1e-4, abs=1e-9)
    assert model.simulate("2 ms", solver="ros34prw", step="20 us").time[1] == pytest.approx(2e-5)
    assert np.array_equal(model.rhs(time="1 ms"), model.rhs(time=0.001))
    assert model.state_at("1 ms")[0] == pytest.approx(model.state_at(0.001)[0])
    many = model.simulate_many({"R": ["2 ohm", 3.0]}, "1 ms", every="100 us")
    assert many.time[-1] == 1e-3 and len(many.time) == 11
    at = model.linearise(["supply.e"], at="1 ms")
    assert at.time == pytest.approx(1e-3)
    study = trade(model, solvers=["rodas5p"], rtols=[1e-4], duration="1 ms", budget="20 s")
    assert study.duration == 1e-3 and "<table" in study._repr_html_()


def test_a_wrong_argument_is_refused_at_the_door(model, result):
    assert code_of(model.simulate, duration=[1, 2]) == "BG790"
    assert code_of(model.simulate, duration=True) == "BG790"
    assert code_of(model.simulate, duration="2 kg") == "BG063"
    assert code_of(model.simulate, step="fast") == "BG062"
    assert code_of(model.simulate, parameters={"R": None}) == "BG790"
    assert code_of(model.sweep, {"R": None}) == "BG790"
    assert code_of(model.rhs, 0.1) == "BG791"
    assert code_of(model.jacobian, [1, 2, 3]) == "BG791"
    assert code_of(result.__getitem__, "capacitor") == "BG065"


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("parameters", 3, "`parameters` has the type int, where a mapping such as a dict or None"),
        ("parameters", ["R"], "`parameters` has the type list"),
        ("solver", 3, "`solver` has the type int, where a text or None"),
        ("start", 1, "`start` has the type int, where a text or None"),
        ("substeps", 2.5, "`substeps` has the type float, where an integer or None"),
        ("devices", "hand", "`devices` has the type str"),
    ],
)
def test_an_argument_of_another_type_is_a_type_error_with_its_name(model, name, given, message):
    with pytest.raises(TypeError, match=re.escape(message)) as caught:
        model.simulate(**{name: given})
    assert len(caught.traceback) == 2  # this line, and the door


# --- short errors ---------------------------------------------------------------------------

SCRIPT = """
import bgc
def mine():
    bgc.compile("wrong.bg")
mine()
"""


def test_an_error_in_a_script_is_short_and_shows_the_excerpt(tmp_path):
    (tmp_path / "wrong.bg").write_text(MODEL.replace("coil      : I(L)", "coil      : I(l)"))
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.stderr.count("\n  File ") <= 4  # module, function, door
    assert "9 |   coil      : I(l);" in done.stderr
    assert "^" in done.stderr and "did you mean `L`?" in done.stderr
    assert "During handling" not in done.stderr


def test_an_error_in_a_notebook_is_the_diagnostic_alone(tmp_path):
    (tmp_path / "wrong.bg").write_text("model A { x : Q; }")
    with pytest.raises(BgError) as caught:
        bgc.compile(tmp_path / "wrong.bg")
    lines = caught.value._render_traceback_()
    assert lines[0].startswith("error[BG201]") and "File" not in "".join(lines)


# --- views ----------------------------------------------------------------------------------


def test_views_of_a_model(model, tmp_path):
    drawing = model.graph()
    assert "<svg" in drawing._repr_svg_() and drawing.dot.startswith("digraph")
    drawing.save(tmp_path / "a.dot")
    assert (tmp_path / "a.dot").read_text() == drawing.dot
    assert code_of(drawing.save, tmp_path / "a.txt") == "BG070"
    assert "`coil` integrates the effort" in repr(model.causality)
    assert "<table" in model.causality._repr_html_() and len(model.causality) == 3
    assert "coil.p' = 5 - 1 / C * capacitor.q" in repr(model.equations)
    assert r"\begin{align*}" in model.equations._repr_latex_()
    assert "capacitor.q" in model._repr_html_() and "2 ohm" in model._repr_html_()


def test_reprs_and_keys(model, result):
    html = result._repr_html_()
    assert "capacitor.e" in html and "data:image/png" in html and ">+-</th>" in html
    assert result._ipython_key_completions_() == ["time", "capacitor.e", "loop.f"]
    assert model.parameters._ipython_key_completions_() == ["R", "L", "C"]
    assert result.plot()._repr_png_().startswith(b"\x89PNG")
    many = model.simulate_many({"R": [1.0, 2.0]})
    assert many._ipython_key_completions_() == ["time", "capacitor.e", "loop.f"]
    assert "R" in many._repr_html_() and many.plot()._repr_png_().startswith(b"\x89PNG")
    linear = model.linearise(["supply.e"])
    assert "<table" in linear._repr_html_() and "2 states" in repr(linear)


def test_what_analysis_and_studies_return_shows_tables_or_one_line(model):
    assert "control" in dir(bgc) and bgc.control.margins
    loop = model.linearise(["supply.e"], ["capacitor.e"])
    margins = bgc.control.margins(loop)
    study = model.sweep({"R": "1..10 ohm:9"}, ["max(capacitor.e)"])
    for shown, word in (
        (margins, "the closed loop is stable"),
        (study.statistics(), "statistics over 9 runs"),
        (study.sensitivity(), "rank correlation"),
        (model.optimise({"R": "1..3 ohm"}, minimise="max(capacitor.e)", runs=9), "best design"),
    ):
        assert word in repr(shown) and "array(" not in repr(shown)
        assert word in shown._repr_html_() and "<table" in shown._repr_html_()
    for line in (
        bgc.control.frequency_response(loop),
        bgc.control.step_response(loop),
        bgc.control.root_locus(loop),
        model.symbolic(),
    ):
        assert repr(line).startswith("<bgc ") and len(repr(line)) < 100
    latex = model.equations._repr_latex_()
    assert "%" not in latex and latex.splitlines()[0] == "equations"


def test_python_control_gets_names_without_dots(model):
    system = model.linearise(["supply.e"], ["capacitor.e", "loop.f"]).to_ss("control")
    assert system.input_labels == ["supply_e"]
    assert system.output_labels == ["capacitor_e", "loop_f"]
    assert system.state_labels == ["coil_p", "capacitor_q"]
    linear = model.linearise(["supply.e"], ["capacitor.e"])
    twice = replace(linear, outputs=("a.b", "a_b"), C=np.eye(2), D=np.zeros((2, 1)))
    assert twice.to_ss("control").output_labels == ["a_b_0", "a_b_1"]


def test_exports_hold_the_values_and_their_units(model, result):
    data = result.to_xarray()
    assert np.array_equal(data["capacitor.e"], result["capacitor.e"])
    assert data["loop.f"].attrs["units"] == "A" and data.attrs["solver"] == result.solver
    many = model.simulate_many({"R": [1.0, 2.0]})
    frame = many.to_pandas()
    assert list(frame.index.names) == ["instance", "R", "time"]
    assert np.array_equal(frame.xs(1, level="instance")["loop.f"], many["loop.f"][1])
    assert np.array_equal(many.run(1)["loop.f"], many["loop.f"][1])


def test_a_missing_package_is_named(model, result, monkeypatch):
    monkeypatch.setitem(sys.modules, "polars", None)
    monkeypatch.setitem(sys.modules, "control", None)
    assert code_of(result.to_polars) == "BG058"
    assert code_of(model.linearise(["supply.e"]).to_ss, "control") == "BG058"


def test_polars_gets_a_column_for_each_name(result):
    polars = pytest.importorskip("polars")
    assert isinstance(result.to_polars(), polars.DataFrame)
    assert result.to_polars().columns == ["time", "capacitor.e", "loop.f"]


def test_one_input_and_one_output_are_names(model):
    one = model.linearise("supply.e", "capacitor.e")
    np.testing.assert_array_equal(one.B, model.linearise(["supply.e"], ["capacitor.e"]).B)
    assert one.outputs == ("capacitor.e",)


def test_a_linear_form_is_a_state_space_of_scipy(model):
    from scipy.signal import step

    linear = model.linearise(["supply.e"], ["capacitor.e"])
    _, values = step(linear.to_ss(), T=np.linspace(0, 0.01, 1001))
    run = model.simulate(0.01, every=1e-5, rtol=1e-10)
    assert 5 * values == pytest.approx(run["capacitor.e"], abs=1e-5)
    mass = 2 * np.eye(2)
    doubled = Linearisation(
        2 * linear.A, 2 * linear.B, linear.C, linear.D, mass, linear.states, linear.inputs,
        linear.outputs, linear.units, linear.point, 0.0,
    )  # fmt: skip
    assert np.allclose(doubled.to_ss().A, linear.A)
    with_constraint = replace(doubled, E=np.diag([1.0, 0.0]))
    assert not with_constraint.is_explicit and code_of(with_constraint.to_ss) == "BG794"


# --- stepwise -------------------------------------------------------------------------------


def test_a_stepwise_run_is_the_run(model):
    whole = model.simulate("4 ms", every="1 ms", rtol=1e-10)
    with model.step(rtol=1e-10) as run:
        assert run.time == 0.0 and run["capacitor.e"] == 0.0
        found = [run.advance("1 ms")["capacitor.e"] for _ in range(4)]
        assert run.state == pytest.approx(model.state_at(4e-3)[0], rel=1e-4)
        assert run.time == pytest.approx(4e-3) and "0.004 s" in repr(run)
    assert found == pytest.approx(whole["capacitor.e"][1:], rel=1e-7)
    assert code_of(run.advance, 1) == "BG792"
    with model.step(parameters={"R": "0 ohm"}) as run:
        assert code_of(run.advance, "1 kg") == "BG063" and code_of(run.advance, [1]) == "BG790"


# --- notebooks ------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def shell():
    found = InteractiveShell.instance()
    found.run_cell("%load_ext bgc")
    yield found
    InteractiveShell.clear_instance()


def test_the_cell_magic_binds_a_model(shell, tmp_path):
    done = shell.run_cell(f"%%bgc motor step --file {tmp_path / 'motor.bg'}\n{MODEL}")
    assert done.success and done.result is shell.user_ns["motor"]
    assert (tmp_path / "motor.bg").read_text() == MODEL
    assert shell.user_ns["motor"].facts.name == "step"
    magic = shell.find_cell_magic("bgc")
    assert code_of(magic, "", MODEL) == "BG793"
    assert code_of(magic, "a b c", MODEL) == "BG793"


def test_the_notebook_of_the_examples_runs(shell):
    cells = json.loads(NOTEBOOK.read_text("utf-8"))["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    assert all(not cell.get("outputs") for cell in cells)
    for source in code:
        done = shell.run_cell(source)
        done.raise_error()
    assert abs(shell.user_ns["natural"] - 1 / (2 * np.pi * np.sqrt(1e-3 * 10e-6))) < 1
