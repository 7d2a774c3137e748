"""Check packages and programs that the site needs, before a scene runs: a message for each."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from importlib.util import find_spec

from bgc.building.toolchain import find_toolchain
from bgc.diagnostics.diagnostic import BgError

SITE = 'pip install ".[site]"'
BROWSERS = ("chromium", "chromium-browser", "google-chrome")


def stop_if_missing(*packages: tuple[str, str], programs: tuple[str, ...] = ()) -> None:
    """End the program with status 1 where a package, a program or the C compiler is missing.

    `packages` are names of modules, each with the command that installs it.
    """
    found = list(missing(packages, programs))
    for line in found:
        print(line, file=sys.stderr)
    if found:
        sys.exit(1)


def missing(packages: tuple[tuple[str, str], ...], programs: tuple[str, ...]) -> Iterator[str]:
    """Yield a line for each thing that is missing."""
    for module, command in packages:
        if find_spec(module) is None:
            yield f"the package {module} is missing: {command}"
    for program in programs:
        if shutil.which(program) is None:
            yield f"the program {program} is missing{_REMEDIES.get(program, '')}"
    try:
        find_toolchain()
    except BgError as problem:
        yield f"the C compiler is missing: {problem.diagnostics[0].message}"


def browser() -> str:
    """Return the path of a browser; end the program where there is none."""
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is None:
        print(f"a browser is missing: install one of {', '.join(BROWSERS)}", file=sys.stderr)
        sys.exit(1)
    return found


_REMEDIES = {
    "dot": ": install Graphviz, for example apt-get install graphviz",
    "bgc": ": pip install .",
}
