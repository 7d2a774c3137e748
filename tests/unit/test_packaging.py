"""The package list in pyproject.toml is written by hand: it must match the tree."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = {
    "compiler": "bgc",
    "grammar": "bgc.grammar",
    "library": "bgc.library",
    "runtime": "bgc.runtime",
}


@pytest.fixture(scope="module")
def setuptools_table() -> dict:
    return tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]


COVERED = {".bg", ".csv", ".lark", ".json", ".c", ".h", ".typed", ".j2", ".svg", ".png"}


def packages_in_tree() -> set[str]:
    found = set()
    for folder, package in FOLDERS.items():
        for init in (ROOT / folder).rglob("__init__.py"):
            inner = init.parent.relative_to(ROOT / folder).parts
            found.add(".".join((package, *inner)))
    return found


def test_every_package_is_listed(setuptools_table):
    assert set(setuptools_table["packages"]) == packages_in_tree()


def test_every_listed_package_has_its_folder(setuptools_table):
    for package, folder in setuptools_table["package-dir"].items():
        assert (ROOT / folder / "__init__.py").is_file(), package


def test_every_data_file_is_covered_by_a_pattern(setuptools_table):
    folders = setuptools_table["package-dir"]
    covered = {
        path
        for package, patterns in setuptools_table["package-data"].items()
        for pattern in patterns
        for path in (ROOT / folders[package]).glob(pattern)
    }
    for folder in FOLDERS:
        for path in (ROOT / folder).rglob("*"):
            if path.suffix in COVERED:
                assert path in covered, path
    assert ROOT / "library" / "README.md" in covered
    assert ROOT / "grammar" / "LANGUAGE.md" in covered


def test_the_top_level_holds_only_what_was_decided():
    """Files that git keeps; a user may have written results beside them."""
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        pytest.skip("not a checkout")
    listed = subprocess.run(
        ["git", "-c", "safe.directory=*", "ls-files"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    visible = {name.split("/")[0] for name in listed.stdout.splitlines() if name[0] != "."}
    folders = {"grammar", "compiler", "runtime", "library", "tests"}
    assert visible == {"pyproject.toml", "README.md", "LICENSE", *folders}


MODEL = """
model RC {
  param R = 2 ohm;
  supply : Se(e = 5 V); loop : J1; resistor : R(R); capacitor : C(3 F);
  supply -> loop -> resistor, capacitor;
}
scene charge of RC { observe capacitor.e; run 6 s every 2 s; }
"""

FROM_TEXT_TO_C = {
    "compile": "import bgc; bgc.compile('rc.bg').simulate()",
    "build": "command('build', 'rc.bg', '--target', 'c')",
    "run": "command('run', 'rc.bg', '--out', 'rc.csv')",
    "check": "command('check', 'rc.bg')",
    "equations": "command('equations', 'rc.bg', '--latex')",
}


@pytest.mark.slow
@pytest.mark.parametrize("way", FROM_TEXT_TO_C)
def test_the_way_from_text_to_c_imports_neither_sympy_nor_jinja2(way, tmp_path):
    """Both are for what a user asks for beside a run; SymPy alone takes 0.3 s to import."""
    (tmp_path / "rc.bg").write_text(MODEL)
    program = (
        "import sys\n"
        "from bgc.runtime.cli.app import application\n"
        "def command(*arguments):\n"
        "    try:\n"
        "        application.main(list(arguments))\n"
        "    except SystemExit as ended:\n"
        "        assert not ended.code\n"
        f"{FROM_TEXT_TO_C[way]}\n"
        "print(sorted({'sympy', 'jinja2', 'bgc.symbolic'} & set(sys.modules)))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=tmp_path,
        env={**os.environ, "BGC_CACHE_DIR": str(tmp_path / "cache")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "[]"


def test_sympy_and_jinja2_are_installed_with_bgc():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    names = {re.split(r"[<>=]", text)[0] for text in project["dependencies"]}
    assert {"sympy", "jinja2"} <= names


def test_each_dependency_has_a_lowest_version_that_exists_and_is_tested():
    # `np.trapezoid` came with NumPy 2; `.ci/run` installs these versions and runs some tests.
    text = (ROOT / "pyproject.toml").read_text("utf-8")
    listed = tomllib.loads(text)["project"]["dependencies"]
    lowest = dict(dependency.split(">=") for dependency in listed)
    assert int(lowest["numpy"].split(".")[0]) >= 2
    assert all(version.count(".") for version in lowest.values())
    assert 'say "lowest versions' in (ROOT / ".ci" / "run").read_text("utf-8")
