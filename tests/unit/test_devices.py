"""Drivers by name and by path, in scenes and on the command line; `bgc devices`."""

from __future__ import annotations

import ctypes.util
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from manual import whole_manual
from refusals import refusals

import bgc
from bgc.driver import check_source
from bgc.language.scene_tables import DRIVER_OPTIONS
from bgc.runtime.cli.app import application
from bgc.runtime.realtime.device_discovery import HARDWARE, find_all, find_library
from bgc.runtime.running.device_drivers import read_choice

SCENE = """model Held {{
  input x[3] : m;
  state follows = 0 m;
  der(follows) = 10 s^-1*(x[1] - follows);
}}
scene s of Held {{
  device hand = {driver};
  drive x = hand.position;
  drive hand.force = [-20 N/m*hand.position[1], 0 N, 0 N];
  observe x[1] as x, follows; step 10 ms; run 1 s every 10 ms;
}}
"""


def bgc_command(*arguments: object) -> tuple[int, str]:
    done = CliRunner().invoke(application, [str(part) for part in arguments])
    return done.exit_code, done.output


@pytest.fixture(scope="module")
def example(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example driver, made as its user makes it."""
    folder = tmp_path_factory.mktemp("own") / "hand"
    status, text = bgc_command("devices", "--example", folder)
    assert status == 0 and "make -C" in text
    made = subprocess.run(["make", "-C", folder, "CC=cc"], capture_output=True, text=True)
    assert made.returncode == 0 and "warning" not in made.stderr, made.stderr
    status, text = bgc_command("devices", "--example", folder)
    assert status == 1 and "BG055" in text  # an edited mine.c is not overwritten
    return folder / "mine.so"


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scene")
    (folder / "still.csv").write_text("time,x,y,z\n0,1,0,0\n")
    path = folder / "held.bg"
    path.write_text(SCENE.format(driver='trace(file = "still.csv")'))
    return path


def swing(amplitude: float) -> np.ndarray:
    return amplitude * np.sin(np.pi * np.linspace(0.0, 1.0, 101))


def test_the_example_driver_replaces_that_of_the_scene(example: Path, scene: Path) -> None:
    model = bgc.compile(scene)
    assert model.simulate()["x"][-1] == 1.0
    result = model.simulate(devices={"hand": f"{example}(amplitude=30 mm)"})
    np.testing.assert_allclose(result["x"], swing(0.03), atol=1e-12)
    out = scene.parent / "rows.csv"
    status, text = bgc_command("run", scene, "--device", f"hand={example}", "--out", out, "-q")
    assert status == 0, text
    rows = np.genfromtxt(out, delimiter=",", names=True)
    np.testing.assert_allclose(rows["x"], swing(0.05), atol=1e-12)


def test_a_scene_loads_code_only_from_listed_folders(
    example: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "own.bg"
    path.write_text(SCENE.format(driver=f'driver("{example}", amplitude = 3 cm)'))
    assert check_source(path) == []
    model = bgc.compile(path)
    assert refusals(model.simulate)[0].code == "BG015"
    monkeypatch.setenv("BGC_DRIVERS", f"{tmp_path}:{example.parent}")
    np.testing.assert_allclose(model.simulate()["x"], swing(0.03), atol=1e-12)
    found = {finding.name: finding for finding in find_all(tmp_path)}
    assert found[str(example)].usable
    path.write_text(SCENE.format(driver="driver(amplitude = 3 cm)"))
    assert [d.code for d in check_source(path)] == ["BG016"]


@pytest.mark.parametrize(
    ("choice", "code", "words"),
    [
        ("hand", "BG013", "does not choose"),
        ("hand=udp(port)", "BG013", "does not choose"),
        ("hnad=trace(file=a.csv)", "BG014", "no device `hnad`"),
        ("hand=omega()", "BG073", "omega"),
        ("hand=./absent.so", "BG012", "no such file"),
        ("hand=./text.so", "BG012", "cannot be used"),
        ("hand=./libc.so", "BG012", "exports no function `bgc_device_driver`"),
        ("hand=./old.so", "BG012", "version 7 of bgc_device.h"),
        ("hand=absent.csv", "BG074", "absent.csv"),
    ],
)
def test_a_choice_that_cannot_be_used(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, choice: str, code: str, words: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "text.so").write_text("no machine code")
    if "libc.so" in choice:
        (tmp_path / "libc.so").symlink_to(ctypes.util.find_library("m") and _libm())
    if "old.so" in choice:
        text = "static const int old[20] = {7}; const void *bgc_device_driver(void) {return old;}"
        (tmp_path / "old.c").write_text(text)
        subprocess.run(["cc", "-shared", "-fPIC", "-o", "old.so", "old.c"], check=True)
    status, text = bgc_command("run", scene, "--device", choice, "-q")
    assert status == 1 and f"error[{code}]" in text and words in text, text


def _libm() -> str:
    lines = Path("/proc/self/maps").read_text().split("\n")
    return next(line.split()[-1] for line in lines if "libm" in line)


def test_choices_are_read_with_units_and_paths(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    name, choice = read_choice('hand = udp(port=5005, delay=20 ms, host="10.0.0.2")')
    assert (name, choice.driver, choice.path) == ("hand", "udp", None)
    assert choice.options == "port=5005\ndelay=0.02\nhost=10.0.0.2\n"
    assert read_choice("h=a.csv(loop=1)")[1].options == f"file={tmp_path}/a.csv\nloop=1\n"
    assert read_choice("h=./mine.so")[1].path == tmp_path / "mine.so"


def machine(root: Path, rule: bool, mode: int | None) -> None:
    """A file system with a connected device of Force Dimension."""
    port = root / "sys/bus/usb/devices/1-2"
    port.mkdir(parents=True)
    facts = {"idVendor": "1451", "idProduct": "0402", "product": "omega.x", "busnum": "1"}
    for name, text in {**facts, "devnum": "5"}.items():
        (port / name).write_text(text + "\n")
    rules = root / "etc/udev/rules.d"
    rules.mkdir(parents=True)
    if rule:
        (rules / "40-haptic.rules").write_text('ATTR{idVendor}=="1451", MODE="0666"\n')
    if mode is not None:
        node = root / "dev/bus/usb/001/005"
        node.parent.mkdir(parents=True)
        node.write_text("")
        node.chmod(mode)


@pytest.mark.parametrize(
    ("rule", "node", "usable", "words", "remedy"),
    [
        (False, False, False, "no udev rule", 'ATTR{idVendor}=="1451"'),
        (True, False, False, "is not writable", "plug it in again"),
        (True, True, True, "omega.x (USB 1451:0402", ""),
    ],
)
def test_a_connected_device_and_why_it_cannot_be_opened(
    tmp_path: Path, rule: bool, node: bool, usable: bool, words: str, remedy: str
) -> None:
    from bgc.runtime.realtime.device_discovery import _connected, _examine_port

    machine(tmp_path, rule, 0o666 if node else None)
    (port,) = _connected(HARDWARE[0], tmp_path)
    finding = _examine_port(HARDWARE[0], port, tmp_path)
    assert finding.usable is usable and words in finding.text and remedy in finding.remedy


def test_the_library_of_a_maker_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("FDSDK", raising=False)
    assert find_library(HARDWARE[0], tmp_path) is None
    for place in ("usr/local/lib", "sdk/lib/release/lin-x86_64-gcc"):
        (tmp_path / place).mkdir(parents=True)
        (tmp_path / place / "libdrd.so.3.17.0").write_text("")
    assert find_library(HARDWARE[0], tmp_path) == tmp_path / "usr/local/lib/libdrd.so.3.17.0"
    monkeypatch.setenv("FDSDK", str(tmp_path / "sdk"))
    found = find_library(HARDWARE[0], tmp_path)
    assert found is not None and "lin-x86_64" in str(found)


def test_devices_lists_every_driver() -> None:
    status, text = bgc_command("devices")
    assert status == 0 and "ok  trace" in text
    listed = {line.split()[1] for line in text.splitlines() if line.startswith(("ok", "--"))}
    assert set(DRIVER_OPTIONS) <= listed


def test_a_scene_may_use_every_driver_of_the_manual(tmp_path: Path) -> None:
    table = whole_manual().partition("| driver | options | gives |\n")[2].partition("\n\n")[0]
    rows = [re.match(r"\| `(\w+)` \|", line) for line in table.splitlines()[1:]]
    names = {row[1] for row in rows if row}
    assert len(names) >= 7
    path = tmp_path / "own.bg"
    for name in sorted(names - {"trace", "udp"}):  # those need a file and a port
        path.write_text(SCENE.format(driver=f"{name}()"))
        assert check_source(path) == [], name
