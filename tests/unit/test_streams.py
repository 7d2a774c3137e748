"""Commands where the machine or its user is at fault: standard streams, signals, folders."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from processes import started

from bgc.diagnostics.catalogue.machine import system_refuses

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="POSIX shells")

MODEL = "model M { state x = 1; der(x) = -x; } scene s of M { observe x; run 1 s; }"
BGC = f"{sys.executable} -c 'from bgc.runtime.cli import main; main()'"


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "m.bg"
    path.write_text(MODEL)
    return path


def shell(command: str, folder: Path, **environment: str) -> tuple[int, str]:
    """Status and standard error of a shell command."""
    done = subprocess.run(
        ["sh", "-c", command],
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    return done.returncode, done.stderr


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
@pytest.mark.parametrize(
    "command",
    ["run m.bg --out -", "build m.bg --target c -o -", "run m.bg", "doc TF", "check --help"],
)
def test_a_full_disk_behind_standard_output_is_the_machines_fault(model, command):
    status, complaint = shell(f"{BGC} {command} > /dev/full", model.parent)
    assert (status, complaint.split("\n")[0]) == (
        1,
        "error[BG048]: the operating system reports an error: No space left on device",
    )


@pytest.mark.parametrize("command", ["run m.bg", "run missing.bg", "check m.bg", "run m.bg --no"])
def test_closed_standard_error_changes_no_status(model, command):
    expected, _ = shell(f"{BGC} {command}", model.parent)
    assert shell(f"{BGC} {command} 2>&-", model.parent) == (expected, "")


def test_messages_do_not_go_into_a_file_that_took_the_number_of_a_closed_stream(model):
    status, _ = shell(f"{BGC} run m.bg --quiet --out r.csv <&- >&- 2>&-", model.parent)
    assert status == 0
    assert (model.parent / "r.csv").read_text().startswith("time,x\n0.0,1.0\n")


def test_rows_for_closed_standard_output_are_an_error(model):
    status, complaint = shell(f"{BGC} run m.bg --quiet --out - >&-", model.parent)
    assert (status, "BG048" in complaint) == (1, True)


@pytest.mark.parametrize("cc", ['"', "''", "'a", "\\"])
def test_a_cc_that_is_not_a_command_is_refused(model, cc):
    status, complaint = shell(f"{BGC} run m.bg", model.parent, CC=cc)
    assert (status, complaint.startswith("error[BG051]: ")) == (1, True), complaint


@pytest.mark.parametrize(
    ("command", "status", "code"),
    [
        ("run {path} --quiet", 0, ""),
        ("run m.bg", 1, "BG001"),
        ("run {path} --out r.csv", 1, "BG048"),
        ("build {path} -o out", 1, "BG055"),
        ("check {path}", 0, ""),
        ("doctor", 0, ""),
    ],
)
def test_a_working_directory_that_was_deleted_is_survived(model, command, status, code):
    text = f"mkdir gone; cd gone; rmdir ../gone; {BGC} {command.format(path=model)}"
    found, complaint = shell(text, model.parent, CC="cc")
    assert (found, code in complaint, "Traceback" in complaint) == (status, True, False), complaint


def test_a_compiler_that_writes_nothing_is_named(model):
    status, complaint = shell(f"{BGC} run m.bg", model.parent, CC="/bin/true", BGC_CACHE_DIR="c")
    assert (status, complaint.partition(":")[0]) == (1, "error[BG052]")
    assert "wrote no file" in complaint
    status, _ = shell(f"{BGC} doctor", model.parent, CC="/bin/true")
    assert status == 1


@pytest.mark.parametrize("name", ["x" * 251 + ".csv", "\u00e9" * 125 + ".csv", "p" * 251 + ".png"])
def test_a_name_of_the_greatest_length_is_written(model, name):
    option = "--plot" if name.endswith("png") else "--out"
    status, complaint = shell(f"{BGC} run m.bg --quiet {option} {name}", model.parent)
    assert (status, complaint) == (0, "")
    assert (model.parent / name).stat().st_size > 0


def test_what_memory_lacks_has_the_same_code():
    assert system_refuses("there is not enough memory", "").code == "BG048"


@pytest.mark.usefixtures("terminal_signals")
@pytest.mark.parametrize(
    ("name", "status"),
    [("SIGINT", 130), ("SIGTERM", 143), ("SIGHUP", 129)],
)
@pytest.mark.parametrize(
    "module", ["click", "bgc.runtime.cli.app", "numpy", "numpy._core.multiarray", "lark"]
)
def test_a_signal_during_an_import_ends_it_quietly(model, module, name, status):
    text = f"""
import os, signal, sys
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            os.kill(os.getpid(), signal.{name})
from bgc.runtime.cli import main
sys.meta_path.insert(0, Finder())
sys.argv = ["bgc", "run", "m.bg", "--set", "x=1"]
main()
"""
    done = subprocess.run(
        [sys.executable, "-c", text], cwd=model.parent, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr.strip()) == (status, "", "")


def test_an_ignored_signal_stays_ignored(model):
    text = (
        "import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN);"
        "from bgc.runtime.cli.signals import catch_signals; catch_signals();"
        "import os; os.kill(os.getpid(), signal.SIGHUP); print('goes on')"
    )
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    assert done.stdout == "goes on\n"


@pytest.mark.usefixtures("terminal_signals")
@pytest.mark.slow
def test_a_terminal_that_is_closed_keeps_the_rows(model):
    model.write_text(MODEL.replace("run 1 s", "run 1e7 s every 100 s"))
    master, slave = os.openpty()
    command = [sys.executable, "-c", "from bgc.runtime.cli import main; main()", "run", "m.bg"]
    with started(
        [*command, "--solver", "rk4", "--step", "1 ms", "--out", "r.csv"],
        cwd=model.parent,
        stdout=slave,
        stderr=slave,
        env={**os.environ, "TERM": "xterm"},
    ) as process:
        os.close(slave)
        seen = b""
        while b"simulating" not in seen:
            seen += os.read(master, 4096)  # ends with an error where the process ends without it
        os.close(master)
        time.sleep(0.3)  # the bar is drawn on a terminal that is gone
        process.send_signal(signal.SIGHUP)
        assert process.wait(timeout=30) == 129
    assert (model.parent / "r.csv").read_text().startswith("time,x\n0.0,1.0\n")


@pytest.mark.usefixtures("terminal_signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_compilers_too(model, number):
    begun, compiler = model.parent / "begun", model.parent / "cc"
    compiler.write_text(
        f'#!/bin/sh\n[ "$1" = --version ] && exit\necho $$ >> {begun}\nexec sleep 60\n'
    )
    compiler.chmod(0o755)
    with started(
        [sys.executable, "-c", "from bgc.runtime.cli import main; main()", "run", "m.bg"],
        cwd=model.parent,
        env={**os.environ, "CC": str(compiler), "BGC_CACHE_DIR": str(model.parent / "cache")},
    ) as process:
        while not (begun.exists() and begun.read_text().endswith("\n")):
            assert process.poll() is None
            time.sleep(0.05)
        process.send_signal(number)
        assert process.wait(timeout=20) == 128 + number
    for compiling in begun.read_text().split():
        with pytest.raises(ProcessLookupError):
            os.kill(int(compiling), 0)
