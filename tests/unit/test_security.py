"""Each sentence of the lists in the manual's chapter `Security`, with the test behind it."""

from __future__ import annotations

import asyncio
import json
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar
from zipfile import ZipFile

import aiohttp
import numpy as np
import pytest
from click.testing import CliRunner
from foreign_fmus import LAG, foreign_fmu
from manual import chapter_named
from processes import started
from refusals import codes_of
from view_server import address, home, serving

import bgc
import bgc.grammar
import bgc.runtime
from bgc.building.cache import Cache
from bgc.building.platforms import host_platform
from bgc.building.toolchain import find_toolchain
from bgc.building.user_folder import cache_directory
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.render import render
from bgc.driver import compile_scene
from bgc.options import Options
from bgc.runtime.cli.app import application
from bgc.runtime.running.device_drivers import _located
from bgc.runtime.view.server import Server

PROMISED: set[str] = set()

_Test = TypeVar("_Test", bound=Callable[..., None])


def promise(sentence: str) -> Callable[[_Test], _Test]:
    """Note that a test stands behind a sentence of the manual."""
    PROMISED.add(sentence)
    return lambda test: test


def sentences() -> set[str]:
    """The items of the lists of the chapter, each on one line and without its links."""
    chapter = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", chapter_named("evidence/security"))
    items = re.findall(r"^- (.+(?:\n  .+)*)", chapter, re.MULTILINE)
    return {" ".join(item.split()) for item in items}


def test_a_test_stands_behind_each_sentence():
    assert sentences() == PROMISED


def run_bgc(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(application, [str(argument) for argument in arguments])
    return result.exit_code, result.output + result.stderr


_SMALL = "model M { state x = 1; der(x) = -x; } scene s of M { observe x; run 1 s; }"
CART = """
model Cart {{
  input v : m/s = 0 m/s;
  push : Sf(f = v);
  motion : J0;
  drag : R(2);
  push -> motion -> drag;
}}
scene pull of Cart {{
  device hand = trace({options});
  drive v = hand.velocity[1];
  observe drag.e;
  run 10 ms;
}}
"""


def cart(folder: Path, options: str) -> Path:
    path = folder / "cart.bg"
    path.write_text(CART.format(options=options), encoding="utf-8")
    return path


# --- a stranger's model ---------------------------------------------------------------------

PLOT = ("--plot", "results/rows.png", "--quiet")
_WATCHED = """
import json, os, sys
seen = []
def watch(event, arguments):
    if event == "subprocess.Popen":
        seen.append([event, str(arguments[0])])
    elif event in ("os.system", "os.exec", "os.posix_spawn", "os.fork", "socket.connect"):
        seen.append([event, repr(arguments)])
    elif event == "open" and isinstance(arguments[0], (str, bytes)):
        if arguments[2] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):
            seen.append([event, os.path.abspath(os.fsdecode(arguments[0]))])
sys.addaudithook(watch)
from bgc.runtime.cli.app import application
try:
    application.main(args=sys.argv[1:], prog_name="bgc")
finally:
    print(json.dumps(seen))
"""


@pytest.mark.slow
@promise(
    "`bgc` on a model starts no program but the C compiler, opens no network connection, and "
    "writes only to its cache, to temporary files and to the files that the command line names."
)
def test_what_a_command_does_on_this_machine(tmp_path):
    (tmp_path / "motion.csv").write_text("time,x,y,z\n0,0,0,0\n1,1,0,0\n")
    path = cart(tmp_path, 'file = "motion.csv"')
    folders = {name: tmp_path / name for name in ("cache", "temporary", "results")}
    for folder in folders.values():
        folder.mkdir(mode=0o700)
    (tmp_path / "matplotlibrc").write_text("text.usetex: True\n")
    out = folders["results"] / "rows.csv"
    done = subprocess.run(
        [sys.executable, "-B", "-c", _WATCHED, "run", path, "--out", out, *PLOT],
        capture_output=True,
        text=True,
        check=True,
        cwd=tmp_path,
        env={
            **os.environ,
            "BGC_CACHE_DIR": str(folders["cache"]),
            "TMPDIR": str(folders["temporary"]),
        },
    )
    seen = json.loads(done.stdout)
    assert (tmp_path / "results" / "rows.png").is_file()
    started = {where for what, where in seen if what == "subprocess.Popen"}
    assert started == {find_toolchain().command[0]}
    written = {where for what, where in seen if what == "open"}
    assert str(out.parent) in {str(Path(where).parent) for where in written}
    allowed = (*map(str, folders.values()), os.devnull)
    assert [where for where in written if not where.startswith(allowed)] == []
    assert {what for what, _ in seen} == {"subprocess.Popen", "open"}


@promise(
    "No program and no Python module is taken from the current directory, nor from that of the "
    "model."
)
@pytest.mark.slow
@pytest.mark.parametrize("kind", ["ziglang", "plugin"])
def test_nothing_of_the_current_directory_is_run(tmp_path, kind):
    marker = tmp_path / "marker"
    names = {"ziglang": ["ziglang/__main__.py", "ziglang/__init__.py"]}
    shadows = ["numpy.py", "click.py", "lark.py", "json.py", "sitecustomize.py"]
    for name in names.get(kind, shadows):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(f"open({str(marker)!r}, 'w').close()")
    for name in ("cc", "gcc", "clang", "tcc", "dot"):
        (tmp_path / name).write_text(f"#!/bin/sh\ntouch {marker}")
        (tmp_path / name).chmod(0o755)
    (tmp_path / "m.bg").write_text("model M { state x = 1; der(x) = -x; }")
    path = str(tmp_path / "no") if kind == "ziglang" else os.environ["PATH"]
    for command in (["doctor"], ["check", "m.bg"], ["graph", "m.bg"]):
        subprocess.run(
            [sys.executable, "-P", "-c", "from bgc.runtime.cli import main; main()", *command],
            cwd=tmp_path,
            env={**os.environ, "PATH": path, "CC": ""},
            capture_output=True,
            check=False,
        )
        assert not marker.exists()


_TRIGRAPHS = {"=": "#", "/": "\\", "'": "^", "(": "[", ")": "]", "!": "|", "<": "{", ">": "}"}


def without_comments_and_literals(text: str) -> str:
    """C text as the compiler reads it, less its comments and string literals."""
    text = re.sub(r"\?\?([=/'()!<>])", lambda found: _TRIGRAPHS[found[1]], text)
    text = text.replace("\\\n", "")
    return re.sub(r'/\*.*?\*/|//[^\n]*|"(?:[^"\\\n]|\\.)*"', " ", text, flags=re.DOTALL)


@promise(
    "Text of a model enters the generated C only in comments and string literals, so a model "
    "cannot add code."
)
@pytest.mark.parametrize("hostile", ["*/ HOSTILE(); /*", "??/", "\\", "%s ??/ HOSTILE", "\u2028"])
def test_text_of_a_model_is_not_code(tmp_path, hostile):
    path = tmp_path / "hostile.bg"
    path.write_text(
        f"/// {hostile} HOSTILE\nmodel M {{ /// {hostile} HOSTILE\n param k = 1; state x = 1;"
        f' der(x) = -k*x; assert x > -1, "HOSTILE {hostile}"; }}'
        f'scene s of M {{ device d = trace(file = "HOSTILE {hostile}"); observe x;'
        f" drive d.gripper_force = 0; run 1 ms; plot x; }}",
        encoding="utf-8",
    )
    emitted = compile_scene(path, Options(), until="emit").emitted
    for unit in emitted.units:
        assert "HOSTILE" in unit.text
        assert "HOSTILE" not in without_comments_and_literals(unit.text)
    bgc.compile(path)


@promise(
    "A model can import any `.bg` file that you may read, and read any regular file of up to "
    "256 MB as a trace, or as data if its name ends in `.csv` or `.json`; pipes, terminals and "
    "devices are refused."
)
@pytest.mark.parametrize("kind", ["pipe", "device", "folder", "proc"])
def test_what_is_not_a_regular_file_is_refused_as_a_trace(tmp_path, kind):
    named = {"device": "/dev/urandom", "folder": str(tmp_path), "proc": "/proc/kmsg"}
    if kind == "pipe":
        os.mkfifo(tmp_path / "pipe")
    name = named.get(kind, "pipe")
    if kind == "proc" and not Path(name).exists():
        pytest.skip("there is no such file here")
    status, output = run_bgc("run", cart(tmp_path, f'file = "{name}"'))
    assert (status, "BG074" in output) == (1, True), output


@pytest.mark.parametrize("kind", ["other ending", "link", "pipe", "device"])
@pytest.mark.parametrize(
    ("ending", "text", "allowed"),
    [
        ("bg", 'import "NAME";', {"BG020", "BG024"}),
        ("csv", 'const d = data("NAME");\n' + _SMALL.replace("-x;", "d.x[1];"), {"BG250"}),
    ],
)
def test_what_is_not_a_regular_file_is_not_read(tmp_path, kind, ending, text, allowed):
    secret = tmp_path / "secret.txt"
    secret.write_text("x\n1\nHUSH:x:0\n")
    name = {"other ending": "secret.txt", "device": "/dev/zero"}.get(kind, f"other.{ending}")
    if kind == "link":
        (tmp_path / name).symlink_to(secret)
    elif kind == "pipe":
        os.mkfifo(tmp_path / name)
    (tmp_path / "entry.bg").write_text(text.replace("NAME", name))
    with pytest.raises(BgError) as error:
        bgc.compile(tmp_path / "entry.bg")
    assert {d.code for d in error.value.diagnostics} & allowed
    assert "HUSH" not in render(error.value.diagnostics, colour=False)


@pytest.mark.parametrize("content", ["x\nHUSH\n", "x\n1\nHUSH,2\n", "x\n\0HUSH"])
def test_messages_quote_no_numbers_of_data(tmp_path, content):
    (tmp_path / "secret.csv").write_text(content)
    (tmp_path / "secret.json").write_text(content)
    for ending in ("csv", "json"):
        text = f'const d = data("secret.{ending}");\n{_SMALL}'.replace("-x;", "d.x[1];")
        (tmp_path / "entry.bg").write_text(text)
        status, output = run_bgc("run", tmp_path / "entry.bg")
        assert (status, "BG251" in output, "HUSH" in output) == (1, True, False), output


@promise(
    "Messages quote lines of `.bg` files only; of a trace they state the line and the column, of "
    "data the line, the titles of columns and the keys."
)
@pytest.mark.parametrize(
    "content",
    ["HUSH:x:0\n", "HUSH,x,y,z\n", "time,x,y,z\n0,0,HUSH,0\n", "time,x,y,z\nHUSH\n", "\0HUSH"],
)
def test_messages_quote_nothing_of_a_trace(tmp_path, content):
    (tmp_path / "secret.txt").write_text(content)
    status, output = run_bgc("run", cart(tmp_path, 'file = "secret.txt"'))
    assert (status, "BG074" in output, "HUSH" in output) == (1, True, False), output


@promise(
    "An FMU that a model names is executed only if this content of it was imported on this machine "
    "by `bgc import`, or lies in a folder that `BGC_DRIVERS` lists; checking, compiling and "
    "importing it execute nothing of it."
)
@pytest.mark.skipif(host_platform() != "linux64", reason="an FMU of 64-bit Linux on x86")
def test_an_fmu_is_executed_only_where_its_user_says_so(tmp_path, monkeypatch):
    marker, scene = tmp_path / "executed", tmp_path / "scene.bg"
    about = LAG.replace("A lag", str(tmp_path))  # a content of its own
    fmu = foreign_fmu(tmp_path / "lag.fmu", 2, (f'-DMARKER="{marker}"',), about)
    scene.write_text(
        'model M { sample 1 s { signal y = fmu("lag.fmu", "x"); } output z = y; }\n'
        "scene s of M { observe z; run 2 s; }\n"
    )

    def executed(*arguments: str) -> tuple[int, bool, str]:
        code, printed = run_bgc(*arguments)
        found = marker.exists()
        marker.unlink(missing_ok=True)
        return code, found, printed

    assert executed("check", str(scene))[:2] == (0, False)
    assert executed("build", str(scene), "-o", str(tmp_path))[:2] == (0, False)
    code, found, printed = executed("run", str(scene))
    assert (code, found) == (1, False) and "BG670" in printed
    monkeypatch.setenv("BGC_DRIVERS", str(tmp_path))
    assert executed("run", str(scene))[:2] == (0, True)
    monkeypatch.delenv("BGC_DRIVERS")
    with ZipFile(fmu, "a") as archive:  # other bytes are another FMU
        archive.writestr("resources/more.txt", "")
    assert executed("run", str(scene))[:2] == (1, False)
    assert executed("import", str(fmu), "-o", "-")[:2] == (0, False)
    assert executed("run", str(scene))[:2] == (0, True)


@promise("Of an FMU files are unpacked into the cache alone, wherever their names lead.")
def test_an_fmu_is_unpacked_into_the_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("BGC_CACHE_DIR", str(tmp_path / "deep" / "down" / "cache"))
    with ZipFile(tmp_path / "a.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", LAG)
        for name in ("/resources/a", "resources/../../../../b", "binaries/../../../c"):
            archive.writestr(name, "a stranger's")
    assert run_bgc("import", str(tmp_path / "a.fmu"), "-o", "-")[0] == 0
    files = {path for path in tmp_path.rglob("*") if path.is_file()} - {tmp_path / "a.fmu"}
    assert files and all((cache_directory() / "fmus") in path.parents for path in files)


@promise("A path in a model cannot add options to a device.")
@pytest.mark.parametrize("separator", ["\u2028", "\u2029", "\x85"])
def test_a_path_ends_at_no_other_character_than_the_drivers_do(tmp_path, separator):
    name = f"motion.csv{separator}scale=7"
    (tmp_path / name).write_text("time,x,y,z\n0,0,0,0\n1,1,0,0\n")
    result = bgc.compile(cart(tmp_path, f'file = "{name}"')).simulate()
    assert result["drag.e"][-1] == pytest.approx(2)


def test_a_folder_with_a_line_break_adds_no_option(tmp_path):
    assert _located("file=a\nloop=1", Path("/x")) == "file=/x/a\nloop=1\n"
    folder = tmp_path / "a\nscale=7"
    folder.mkdir()
    (folder / "motion.csv").write_text("time,x,y,z\n0,0,0,0\n1,1,0,0\n")
    status, output = run_bgc("run", cart(folder, 'file = "motion.csv"'))
    assert (status, "line break" in output) == (1, True), output


@promise(
    "Control characters and marks of direction in names, texts and comments of a model are printed "
    "as escapes."
)
@pytest.mark.parametrize("hostile", ["\x9b31m", "\u202egb", "\u2066x", "\u2028x", "\x85x"])
def test_a_terminal_obeys_nothing_of_a_model(tmp_path, hostile):
    path = tmp_path / "m.bg"
    path.write_text(
        f'import "{hostile}.bg"; /// {hostile} summary\n'
        f"///\n/// | {hostile} |\nmodel M {{ /// {hostile}\n param a = 1; }}"
    )
    outputs = [run_bgc("check", path)[1]]
    path.write_text(path.read_text().partition(";")[2])
    outputs += [run_bgc("doc", path)[1], run_bgc("doc", path, "M")[1]]
    path.write_text(
        "model M { state x = 1; der(x) = 1; "
        f'assert x < 1.5, "{hostile}"; }} scene s of M {{ observe x; run 1 s; }}'
    )
    outputs.append(run_bgc("run", path)[1])
    for output in outputs:
        assert all(line.isprintable() for line in output.split("\n")), repr(output)
    assert any(ascii(hostile[0])[1:-1] in output for output in outputs)


@promise(
    "Texts and models beyond a limit are refused: 16 MB or a million lines of a file (BG005), 100 "
    "ancestors of a model (BG215), 200,000 parts (BG418)."
)
@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("/" * 16_000_001, "BG005"),
        ("\n" * 1_000_001, "BG005"),
        ("model A0 {}" + "".join(f"model A{k} is A{k - 1} {{}}" for k in range(1, 102)), "BG215"),
        ("model A { for i in 1..1000 { for j in 1..201 { r[i, j] : R(1); } } }", "BG418"),
    ],
)
def test_what_is_beyond_a_limit_is_refused(tmp_path, text, code):
    path = tmp_path / "large.bg"
    path.write_text(
        f"{text}\n{_SMALL}" if code != "BG418" else f"{text} scene s of A {{ run 1 s; }}"
    )
    assert codes_of(bgc.compile, path) == [code]


_WAITS = """
import ctypes, signal, sys, threading
from bgc.runtime.cli.signals import catch_signals
from bgc.runtime.running.device_drivers import interruptible
catch_signals()
threading.Timer(0.2, lambda: print("ready", flush=True)).start()
interruptible(lambda: ctypes.CDLL(None).sleep(60))
"""


@promise("Ctrl-C, SIGTERM and SIGHUP are answered while files are read and while a model runs.")
@pytest.mark.usefixtures("terminal_signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals_are_answered_while_c_waits_for_a_file(number):
    with started(
        [sys.executable, "-c", _WAITS], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        process.send_signal(number)
        _, complaint = process.communicate(timeout=20)
    assert "KeyboardInterrupt" in complaint


# --- the cache ------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def filled(tmp_path_factory) -> Path:
    """A model, and the cache that its run has filled inside a folder that did not exist before."""
    folder = tmp_path_factory.mktemp("filled")
    (folder / "m.bg").write_text(_SMALL)
    before = os.umask(0)
    try:
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("BGC_CACHE_DIR", str(folder / "new" / "cache"))
            assert run_bgc("run", folder / "m.bg", "--quiet")[0] == 0
    finally:
        os.umask(before)
    return folder


@pytest.fixture
def cached(filled, tmp_path, monkeypatch) -> Path:
    """A copy of the filled cache and of the folder around it, with their rights."""
    root = shutil.copytree(filled / "new", tmp_path / "new") / "cache"
    monkeypatch.setenv("BGC_CACHE_DIR", str(root))
    return root


@promise(
    "The cache directory and the missing directories above it are made for the user alone, "
    "whatever the umask."
)
def test_the_cache_is_made_for_the_user_alone(cached):
    modes = {folder.stat().st_mode & 0o777 for folder in (cached, cached.parent)}
    assert modes == {0o700}


@pytest.mark.slow
@promise(
    "A cache that belongs to another user, that others may write to, or that stands in a "
    "directory in which all users may replace it, is neither read nor written (BG049); the model "
    "is compiled in a temporary directory."
)
@pytest.mark.parametrize("kind", ["group", "all", "parent", "foreign"])
def test_a_cache_of_others_is_not_used(cached, filled, monkeypatch, kind):
    if kind == "foreign":
        monkeypatch.setattr("os.geteuid", lambda: cached.stat().st_uid + 1)
    elif kind == "parent":
        cached.parent.chmod(0o777)
    else:
        cached.chmod(0o770 if kind == "group" else 0o707)
    for planted in cached.rglob("*.*"):  # whatever would be read or executed
        if planted.is_file():
            planted.unlink()  # this process has the shared object loaded
            planted.write_bytes(b"planted")
    before = {path: path.stat().st_mtime_ns for path in cached.rglob("*")}
    status, output = run_bgc("run", filled / "m.bg")
    assert (status, "warning[BG049]" in output) == (0, True), output
    assert {path: path.stat().st_mtime_ns for path in cached.rglob("*")} == before


def test_a_sticky_directory_is_a_good_place_for_a_cache(cached, filled):
    cached.parent.chmod(0o1777)
    assert "BG049" not in run_bgc("run", filled / "m.bg")[1]


@promise(
    "The cache holds C objects, shared objects and JSON, and no pickle; only its shared objects "
    "are executed."
)
def test_what_the_cache_holds(cached):
    kinds = {path.suffix for path in cached.rglob("*") if path.is_file()}
    assert kinds == {".so", ".o", ".json", ".sum"}
    for path in cached.rglob("*.json"):
        json.loads(path.read_text("utf-8"))
    unsafe = re.compile(r"\b(pickle|marshal|shelve|dill|joblib|allow_pickle=True)\b")
    for package in (bgc, bgc.grammar, bgc.runtime):
        for source in Path(package.__file__).parent.rglob("*.py"):
            if source.name in {"cluster.py", "worker.py", "aside.py"}:
                continue  # from process to process, never on disk
            text = source.read_text("utf-8").replace("allow_pickle=False", "")
            assert not unsafe.search(text), source


@pytest.mark.slow
@promise("A damaged file of the cache counts as absent.")
@pytest.mark.parametrize("suffix", [".so", ".o", ".json", ".sum"])
@pytest.mark.parametrize("content", [b"", b"\0" * 2000])
def test_damaged_files_of_the_cache_are_made_anew(cached, filled, suffix, content):
    for path in cached.rglob(f"*{suffix}"):
        path.unlink()  # this process has the shared object loaded
        path.write_bytes(content)
    assert run_bgc("run", filled / "m.bg", "--quiet") == (0, "")


@pytest.mark.slow
@promise(
    "After each compilation, files that were unused for two months are removed from the cache, and "
    "beyond 2 GB those that were unused for longest."
)
def test_the_cache_is_bounded(cached, monkeypatch):
    objects = sorted(cached.glob("objects/*.o"))
    for age, path in enumerate(objects):
        os.utime(path, (path.stat().st_atime, path.stat().st_mtime - 3600 * (age + 1)))
    sizes = {path: path.stat().st_size for path in cached.rglob("*.*") if path.suffix != ".sum"}
    held = sum(size for path, size in sizes.items() if path.is_file())
    oldest = objects[-1]
    monkeypatch.setattr("bgc.building.cache._KEEP_BYTES", held - 1)
    Cache(cached).prune()
    assert sorted(cached.glob("objects/*.o")) == objects[:-1]
    assert not oldest.with_name(f"{oldest.name}.sum").exists()
    assert list(cached.glob("models/*.so")) and list(cached.glob("notes/*.json"))
    week = 100 * 24 * 3600
    os.utime(objects[0], (0, objects[0].stat().st_mtime - week))
    Cache(cached).prune()
    assert objects[0] not in set(cached.glob("objects/*.o"))


# --- an interrupted command -----------------------------------------------------------------

# Tests of these sentences; some are in other files.
ELSEWHERE = {
    "A file is written whole or not at all: an interrupted or killed command leaves the earlier "
    "file of that name.": "test_security.py::test_a_file_is_written_whole_or_not_at_all",
    "The rows of a long run replace an earlier file when the run begins, and can be "
    "read at any time.": "test_row_files.py::test_a_killed_process_leaves_a_readable_archive",
    "After Ctrl-C, SIGTERM or SIGHUP, `bgc run` writes the rows up to there, also where the "
    "terminal is gone.": "test_streams.py::test_a_terminal_that_is_closed_keeps_the_rows",
    "An interrupted `bgc sweep` writes the instances that are done and prints how many; the same "
    "command then computes the others, with the same numbers as without an interruption.": (
        "test_ensemble_results.py::test_an_interrupted_ensemble_is_resumed_with_the_same_numbers"
    ),
    "A signal ends the C compilers that a command has started, too.": (
        "test_streams.py::test_a_signal_ends_the_compilers_too"
    ),
}
PROMISED |= set(ELSEWHERE)


@pytest.mark.parametrize("place", ELSEWHERE.values())
def test_tests_of_other_files_exist(place):
    path, name = place.split("::")
    assert f"def {name}(" in Path(__file__).with_name(path).read_text("utf-8")


@pytest.mark.usefixtures("terminal_signals")
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_a_file_is_written_whole_or_not_at_all(tmp_path, number):
    out = tmp_path / "rows.csv"
    out.write_text("earlier")
    text = (
        "import os, sys\nfrom bgc.runtime.results.files import written_whole\n"
        f"with written_whole({str(out)!r}) as aside, aside.open('w') as file:\n"
        f"    file.write('half'); file.flush(); os.kill(os.getpid(), {int(number)})\n"
    )
    assert subprocess.run([sys.executable, "-c", text], capture_output=True, check=False).returncode
    assert out.read_text() == "earlier"


# --- the page ---------------------------------------------------------------------------------


@promise(
    "`bgc view` listens on the loopback interface alone; requests without the token of its "
    "address, from pages of other origins, or for another host are refused."
)
@promise(
    "Its page requests nothing but its own server, and of your files only the meshes that the "
    "scene names."
)
def test_a_page_needs_its_token_its_origin_and_its_host(monkeypatch):
    monkeypatch.setattr("bgc.runtime.view.server.bundle", lambda: "'</script>'")
    description = {"scene": "s", "width": 1, "shapes": []}
    server = Server(description, [], np.zeros((1, 3), np.float32))

    async def visit(session):
        async def status(url, **headers):
            async with session.get(url, headers=headers) as answer:
                return answer.status

        assert await status(address(server)) == 200
        assert await status(address(server, token="wrong")) == 403
        assert await status(f"http://127.0.0.1:{server.port}/") == 403
        assert await status(address(server), Origin="http://example.org") == 403
        assert await status(address(server), Host="example.org") == 403
        assert await status(address(server, "/mesh/0")) == 404
        assert await status(address(server, "/other")) == 404
        for url, headers in (
            (address(server, "/ws"), {}),
            (address(server, "/ws"), {"Origin": "http://example.org"}),
            (address(server, "/ws", "wrong"), home(server)),
        ):
            with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
                await session.ws_connect(url, headers=headers)
            assert refused.value.status == 403
        async with session.get(address(server)) as answer:
            text = await answer.text()
            assert "http" not in text.replace("http://www.w3.org", "")
            policy = answer.headers["Content-Security-Policy"]
            assert "default-src 'none'" in policy and "'</script>'" not in text
            assert policy.split("'nonce-")[1].split("'")[0] in text

    asyncio.run(serving(server, visit))
