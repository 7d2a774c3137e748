import os
import signal
import subprocess
import sys
import textwrap
import threading
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from processes import started

from bgc.building.build import Unit, build_shared_object
from bgc.building.build_result import Built, RunFacts
from bgc.building.cache import Cache
from bgc.building.toolchain import find_toolchain
from bgc.diagnostics.catalogue.pages import pages
from bgc.language.column_names import AccountColumn
from bgc.runtime import model as runtime_model
from bgc.runtime.cli.app import application
from bgc.runtime.results.result import Result as Rows
from bgc.runtime.results.summary import extremes
from bgc.runtime.running import model_loading

OSCILLATOR = Path(__file__).with_name("oscillator.c").read_text()
COLUMNS = ("q", "v", "r[1]", "r[2]", "energy.stored", "energy.residual")
ACCOUNTS = tuple(AccountColumn(name, f"energy.{name}") for name in ("stored", "residual"))


@pytest.fixture(scope="module")
def library(tmp_path_factory) -> Path:
    cache = Cache(tmp_path_factory.mktemp("cache"))
    return build_shared_object((Unit("model", OSCILLATOR),), find_toolchain(), cache)


@pytest.fixture
def oscillator(library, monkeypatch) -> Built:
    """Whatever file is named: a model written by hand, without the compiler."""
    built = Built(library, RunFacts("swing", "Oscillator", COLUMNS, ACCOUNTS, duration=2.0))
    monkeypatch.setattr(model_loading, "load_or_compile", lambda *_, **__: built)
    return built


def bgc(*arguments: object) -> Result:
    return CliRunner().invoke(application, [str(argument) for argument in arguments])


# --- statuses ---------------------------------------------------------------------------------


def test_help_lists_every_command():
    result = bgc("--help")
    assert result.exit_code == 0
    commands = "new check build run causality equations bode show graph fmt doc explain doctor"
    for command in commands.split():
        assert f"\n  {command} " in result.output
        assert bgc(command, "--help").exit_code == 0


@pytest.mark.parametrize(
    "arguments",
    [
        ["nothing"],
        ["run"],
        ["run", "x.bg", "--nothing"],
        ["run", "x.bg", "--rtol", "small"],
        ["run", "x.bg", "--panel", "a"],
        ["build", "x.bg", "--target", "exe"],
        ["new"],
    ],
)
def test_wrong_usage_is_status_2(arguments):
    assert bgc(*arguments).exit_code == 2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["--out", "r.xlsx"], "BG070"),
        (["--plot", "r.bmp"], "BG070"),
        (["--out", "missing/r.csv"], "BG055"),
        (["--set", "mass"], "BG064"),
        (["--use", ""], "BG064"),
        (["--set", "mass=7 m"], "BG063"),
        (["--time", "1 m"], "BG063"),
        (["--every", "soon"], "BG062"),
        (["--solver", "ode45"], "BG071"),
        (["--solver", "rk4", "--step", "1 ms", "--rtol", "1e-10"], "BG044"),
        (["--solver", "rk4", "--step", "1 ms", "--atol", "1e-10"], "BG044"),
        (["--solver", "rk4", "--step", "1 ms", "--max-step", "1 ms"], "BG044"),
        (["--set", "limit=0"], "BG705"),
    ],
)
def test_what_is_at_fault_is_status_1_and_has_a_code(oscillator, arguments, code):
    result = bgc("run", "x.bg", *arguments)
    assert result.exit_code == 1
    assert f"error[{code}]" in result.stderr


@pytest.mark.parametrize(
    "command", ["run", "sweep", "stress", "trade", "activity", "cost", "build"]
)
def test_a_slip_in_what_fills_a_slot_is_told_with_an_example_of_that(command, tmp_path):
    path = tmp_path / "m.bg"
    path.write_text("model M { state x = 1; der(x) = -x; }\nscene s of M { observe x; run 1 s; }\n")
    vary = ["--vary", "x=1,2", "--out", tmp_path / "m.csv"] if command == "sweep" else []
    result = bgc(command, path, "--use", "nonsense", *vary)
    assert result.exit_code == 1
    assert "BG064" in result.stderr and '--use "elbow' in result.stderr


def test_a_bug_is_status_70_and_shows_its_traceback_only_on_request(monkeypatch):
    def broken(*_: object, **__: object) -> None:
        raise AssertionError("nobody expects this")

    monkeypatch.setattr(model_loading, "load_or_compile", broken)
    monkeypatch.delenv("BGC_DEBUG", raising=False)
    result = bgc("run", "x.bg")
    assert result.exit_code == 70
    assert "nobody expects this" in result.stderr and "Traceback" not in result.stderr
    monkeypatch.setenv("BGC_DEBUG", "1")
    assert "Traceback" in bgc("run", "x.bg").stderr


# --- run ----------------------------------------------------------------------------------------


def test_run_summarises(oscillator):
    result = bgc("run", "x.bg")
    assert result.exit_code == 0, result.stderr
    assert "swing: 2 s simulated in" in result.stdout
    assert "rodas5p" in result.stdout and "1,001 rows" in result.stdout
    assert "energy residual" in result.stdout
    assert bgc("run", "x.bg", "--quiet").stdout == ""


def test_run_prints_its_results_and_names_its_files(oscillator, tmp_path):
    """D9: a run printed no value and named no file."""
    result = bgc("run", "x.bg", "--every", "500 ms", "--out", tmp_path / "r.csv")
    table = np.genfromtxt(tmp_path / "r.csv", delimiter=",", names=True, deletechars="")
    lines = result.stdout.splitlines()
    heads = ["last", "least", "largest", "+-"]
    assert next(line.split() for line in lines if "largest" in line) == heads
    *shown, off = next(line.split()[-4:] for line in lines if line.strip().startswith("q "))
    expected = (table["q"][-1], table["q"].min(), table["q"].max())
    assert [float(value) for value in shown] == pytest.approx(expected, rel=1e-5)
    assert 0 < float(off) < 1e-3
    assert lines[-1] == f"wrote {tmp_path / 'r.csv'} (5 rows)"
    assert "`--out FILE.csv`" in bgc("run", "x.bg").stdout


def test_errors_are_estimated_unless_time_counts(oscillator):
    usual, without = bgc("run", "x.bg").stdout, bgc("run", "x.bg", "--no-error").stdout
    how = "+- local errors, carried along"
    assert "+-" in usual and how not in usual and "+-" not in without
    assert how in bgc("run", "x.bg", "--error").stdout
    assert bgc("run", "x.bg", "--error", "--realtime").exit_code == 2


def test_many_columns_are_counted_and_none_is_a_hint():
    def run_of(names):
        return Rows("s", np.zeros(2), {n: np.ones(2) for n in names}, {}, "rodas5p", {})

    assert "and 8 columns more" in extremes(run_of(map(str, range(20))))
    assert "observe" in extremes(run_of([]))


@pytest.mark.slow
def test_the_first_compilation_names_its_stages(tmp_path):
    """D9: a cold compilation left the terminal blank for seconds."""
    path = tmp_path / "m.bg"
    path.write_text("model M { state x = 1; der(x) = -x; }\nscene s of M { observe x; run 1 s; }\n")
    environment = {**os.environ, "BGC_CACHE_DIR": str(tmp_path / "cache"), "TERM": "xterm"}
    program = (
        "import sys; from bgc.runtime.cli.app import application; application.main(sys.argv[1:])"
    )

    def shown() -> str:
        master, slave = os.openpty()
        command = [sys.executable, "-c", program, "run", str(path)]
        done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=slave, env=environment)
        os.close(slave)
        os.set_blocking(master, False)
        text = b"".join(iter(lambda: _read(master), b"")).decode()
        os.close(master)
        assert done.returncode == 0, text
        return text

    assert "compiling m.bg (first time): C compiler" in shown()
    assert "compiling" not in shown()


def _read(terminal: int) -> bytes:
    try:
        return os.read(terminal, 4096)
    except OSError:
        return b""


def test_run_writes_rows_and_plots(oscillator, tmp_path):
    csv, npz, png = (tmp_path / name for name in ("r.csv", "r.npz", "r.png"))
    every = ("--every", "500 ms")
    assert bgc("run", "x.bg", *every, "--out", csv, "--plot", png).exit_code == 0
    assert bgc("run", "x.bg", *every, "--out", npz).exit_code == 0
    table = np.genfromtxt(csv, delimiter=",", names=True, deletechars="")
    assert table["time"].tolist() == [0.0, 0.5, 1.0, 1.5, 2.0]
    with np.load(npz) as archive:
        assert np.array_equal(archive["q"], table["q"])
    assert png.read_bytes().startswith(b"\x89PNG")


def test_run_writes_csv_to_standard_output_and_the_summary_elsewhere(oscillator):
    result = bgc("run", "x.bg", "--every", "1", "--out", "-")
    lines = result.stdout.splitlines()
    assert lines[0] == "time,q,v,r[1],r[2],energy.stored,energy.residual"
    assert len(lines) == 4
    assert "simulated" in result.stderr


def test_run_takes_times_with_units_and_parameters(oscillator):
    result = bgc(
        "run", "x.bg", "--out", "-", "--time", "100 ms", "--step", "50 ms", "--solver", "rk4",
        "--set", "mass = 4000 g", "--set", "spring.k=0",
    )  # fmt: skip
    assert [line.split(",")[:2] for line in result.stdout.splitlines()[1:]] == [
        ["0.0", "1.0"],
        ["0.05", "1.0"],
        ["0.1", "1.0"],
    ]


def test_a_failed_run_writes_its_rows(oscillator, tmp_path):
    out = tmp_path / "r.csv"
    result = bgc("run", "x.bg", "--set", "s=5", "--out", out, "--plot", tmp_path / "r.png")
    assert result.exit_code == 1
    assert "error[BG70" in result.stderr
    assert "(failed)" in result.stdout
    assert 900 < len(out.read_text().splitlines()) < 1002
    assert (tmp_path / "r.png").is_file()


def test_a_value_that_is_not_finite_is_a_warning(oscillator, monkeypatch):
    simulate = runtime_model.Model.simulate

    def spoil(*arguments, **options):
        result = simulate(*arguments, **options)
        result["q"][1:] = np.nan
        return result

    monkeypatch.setattr(runtime_model.Model, "simulate", spoil)
    result = bgc("run", "x.bg", "--every", "0.5", "--out", "-")
    assert result.exit_code == 0
    assert "warning[BG712]: `q` is not finite from 0.5 s on" in result.stderr
    assert len(result.stdout.splitlines()) == 6


def test_a_parameter_that_the_library_does_not_have_is_compiled_in(oscillator, monkeypatch):
    asked = []

    def build(path: Path, options: object, **_: object) -> Built:
        asked.append(options)
        return oscillator

    monkeypatch.setattr(model_loading, "load_or_compile", build)
    assert bgc("run", "x.bg", "--set", "n=3", "--set", "mass=2").exit_code == 0
    assert [options.overrides for options in asked] == [(), (("n", "3"),)]
    assert bgc("run", "x.bg", "--preview", "--whole", "--use", "a=B").exit_code == 0
    assert (asked[-1].preview, asked[-1].whole, asked[-1].uses) == (True, True, (("a", "B"),))


# --- as a process ---------------------------------------------------------------------------------


def script(built: Built, tmp_path: Path) -> list[str]:
    """A process whose every model is the oscillator, for an hour."""
    text = f"""
        from pathlib import Path
        from bgc.building.build_result import Built, RunFacts
        from bgc.runtime import cli
        from bgc.runtime.running import model_loading
        facts = RunFacts("swing", "Oscillator", ("q",), duration=1e5)
        model_loading.load_or_compile = lambda *_, **__: Built(Path({str(built.library)!r}), facts)
        print("ready", flush=True)
        cli.main()
    """
    path = tmp_path / "script.py"
    path.write_text(textwrap.dedent(text))
    return [sys.executable, str(path)]


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX signals")
@pytest.mark.parametrize(
    ("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]
)
@pytest.mark.usefixtures("terminal_signals")
@pytest.mark.slow
def test_an_interrupted_run_has_its_status_and_keeps_the_rows(oscillator, tmp_path, number, status):
    out = tmp_path / "r.csv"
    command = [*script(oscillator, tmp_path), "run", "x.bg", "--rtol", "1e-12", "--out", str(out)]
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with started(command, text=True, **streams) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        threading.Timer(0.6, process.send_signal, (number,)).start()
        stdout, stderr = process.communicate(timeout=30)
    assert process.returncode == status, stderr
    assert "BG709" in stderr and "interrupted at t =" in stderr
    assert "(interrupted)" in stdout
    assert out.read_text().startswith("time,q\n0.0,1.0\n")


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX signals")
def test_a_closed_pipe_ends_it_quietly(oscillator, tmp_path):
    command = [*script(oscillator, tmp_path), "run", "x.bg", "--time", "100", "--every", "1e-3"]
    process = subprocess.Popen(
        [*command, "--out", "-"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert process.stdout is not None and process.stderr is not None
    process.stdout.readline()
    process.stdout.close()
    process.wait(timeout=30)
    errors = process.stderr.read()
    process.stderr.close()
    assert b"Traceback" not in errors and b"BrokenPipe" not in errors
    assert process.returncode == -signal.SIGPIPE


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX terminals")
@pytest.mark.usefixtures("terminal_signals")
@pytest.mark.slow
def test_a_long_run_shows_its_progress_on_a_terminal(oscillator, tmp_path):
    master, slave = os.openpty()
    command = [*script(oscillator, tmp_path), "run", "x.bg", "--rtol", "1e-13"]
    terminal = {**os.environ, "TERM": "xterm", "COLUMNS": "80"}
    with started(command, stdout=subprocess.DEVNULL, stderr=slave, env=terminal) as process:
        os.close(slave)
        seen = b""
        while b"simulating" not in seen:
            seen += os.read(master, 4096)  # ends with an error where the process ends without it
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=30) == 130
    os.close(master)


def test_a_warm_start_loads_nothing_of_the_compiler(oscillator, tmp_path):
    heavy = {"sympy", "jinja2", "lark", "pint", "matplotlib", "rich", "scipy", "bgc.ir.graph"}
    text = Path(script(oscillator, tmp_path)[1]).read_text().replace("cli.main()", "")
    path = tmp_path / "warm.py"
    path.write_text(
        text
        + "import sys, bgc.building.recall\nfrom bgc.runtime.cli.app import application\n"
        + "try:\n    application.main(['run', 'x.bg', '--time', '1', '--settle', '1 mHz'])\n"
        + "except SystemExit:\n    pass\n"
        + f"print(sorted(set(sys.modules) & {heavy!r}))\n"
    )
    done = subprocess.run([sys.executable, path], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


# --- the others ------------------------------------------------------------------------------


def test_explain_prints_the_page_of_a_code():
    result = bgc("explain", "bg055")
    assert result.output.startswith("BG055  (diagnostic)\nA file cannot be written.\n")
    assert "Way out:" in result.output


@pytest.mark.parametrize("code", ["501", "BG501", "bg501"])
def test_a_code_may_be_given_as_its_number(code):
    assert bgc("explain", code).output.startswith("BG501  (diagnostic)\n")
    assert bgc("explain", code).output == bgc("doc", code).output


def test_explain_lists_all_diagnostics_by_topic():
    lines = bgc("explain").output.splitlines()
    codes = [line.split()[0] for line in lines if line.startswith("  BG")]
    assert sorted(codes) == list(pages())
    heading = lines.index("Causality and algebraic loops")
    assert lines[heading + 1].startswith("  BG501  ")


def test_explain_finds_diagnostics_by_a_word_and_suggests_near_codes():
    assert "  BG501  " in bgc("explain", "prescribe").output
    for wrong in ("BG5O1", "BG500"):
        result = bgc("explain", wrong)
        assert result.exit_code == 1
        assert "error[BG040]" in result.stderr and "BG501" in result.stderr
    assert bgc("explain", "nothing-like-this").exit_code == 1


def test_doctor_is_well_here(monkeypatch, tmp_path):
    monkeypatch.setenv("BGC_CACHE_DIR", str(tmp_path))
    result = bgc("doctor")
    assert result.exit_code == 0
    assert "C compiler" in result.output


def test_doctor_is_status_1_without_a_compiler(monkeypatch, tmp_path):
    monkeypatch.setenv("CC", "no-such-compiler")
    result = bgc("doctor")
    assert result.exit_code == 1
    assert "no-such-compiler" in result.output
