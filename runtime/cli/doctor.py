"""Write and check 7: check compiler, cache and packages of this machine."""

import os
import platform
import re
import shutil
import sys
from collections.abc import Iterator
from contextlib import suppress
from enum import Enum
from importlib.metadata import PackageNotFoundError, requires, version
from importlib.util import find_spec
from pathlib import Path

from bgc.building.cache import open_cache
from bgc.building.toolchain import find_toolchain, try_compiler
from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass
from bgc.runtime.cli.command import command
from bgc.runtime.cli.printing import AT_FAULT, hanging, print_text

_DISTRIBUTION = "bgc-lang"

# What the packages of each extra are for; those of developers are left out.
_EXTRAS = {
    "view": "`bgc view`",
    "zig": "a C compiler, pages that run their model, FMUs for other platforms",
    "lsp": "`bgc lsp`",
    "notebook": "`%%bgc` in Jupyter",
    "pandas": "`result.to_pandas()`",
    "polars": "`result.to_polars()`",
    "xarray": "`result.to_xarray()`",
    "control": '`linear.to_ss("control")`',
    "casadi": "`model.casadi()`",
    "cluster": "`bgc sweep --scheduler`, Zarr files",
    "mujoco": "`bgc import` of MuJoCo's files",
    "hydro": "`bgc import` of hydrodynamic data in HDF5",
}


class Health(Enum):
    """Found, missing but optional, or missing and required."""

    GOOD = "ok"
    OPTIONAL = "--"
    MISSING = "!!"


@dataclass(frozen=True, slots=True)
class Finding:
    """The result for one item, and a remedy if it is missing."""

    name: str
    health: Health
    found: str
    remedy: str = ""


@command()
def doctor() -> int:
    """Check compiler, cache and packages of this machine.

    The exit status is 1 where something needed is missing.
    """
    findings = examine()
    print_text(report(findings))
    return 0 if is_well(findings) else AT_FAULT


def examine() -> tuple[Finding, ...]:
    """Examine all items."""
    return (_python(), _packages(), _compiler(), _cache(), _graphviz(), *_extras())


def is_well(findings: tuple[Finding, ...]) -> bool:
    """Return whether nothing required is missing."""
    return all(finding.health is not Health.MISSING for finding in findings)


def report(findings: tuple[Finding, ...]) -> str:
    """Write findings as a table, with remedies below them."""
    width = max(len(finding.name) for finding in findings)
    lines = []
    for finding in findings:
        name = f"{finding.health.value}  {finding.name:<{width}}  "
        lines.append(hanging(name, finding.found, width + 6))
        if finding.remedy:
            lines.append(hanging(f"{'':{width + 6}}-> ", finding.remedy, width + 9))
    return "\n".join(lines)


def _python() -> Finding:
    return Finding("Python", Health.GOOD, f"{platform.python_version()} at {sys.executable}")


def _packages() -> Finding:
    needed = [text for text in requires(_DISTRIBUTION) or () if "extra ==" not in text]
    names = [re.split(r"[^\w.-]", text, maxsplit=1)[0] for text in needed]
    missing = [name for name in names if find_spec(name) is None]
    if missing:
        remedy = f"pip install {' '.join(missing)}"
        return Finding("Python packages", Health.MISSING, f"no {', '.join(missing)}", remedy)
    return Finding("Python packages", Health.GOOD, "all that are needed")


def _compiler() -> Finding:
    try:
        toolchain = find_toolchain()
    except BgError as problem:
        (diagnostic,) = problem.diagnostics
        return Finding("C compiler", Health.MISSING, diagnostic.message, diagnostic.help)
    if complaint := try_compiler(toolchain):
        found = f"{toolchain.name} fails: {complaint.splitlines()[0]}"
        remedy = "apt-get install gcc libc6-dev, or pip install ziglang"
        return Finding("C compiler", Health.MISSING, found, remedy)
    return Finding("C compiler", Health.GOOD, f"{toolchain.name}: {toolchain.version}")


def _cache() -> Finding:
    cache = open_cache()
    if cache.warnings:
        (warning,) = cache.warnings
        return Finding("cache", Health.OPTIONAL, warning.message, warning.help)
    return Finding("cache", Health.GOOD, f"{cache.root} ({_size_of(cache.root) / 1e6:.1f} MB)")


def _size_of(folder: Path) -> int:
    """Return the bytes of all files; those that another command removes meanwhile are left out."""
    total = 0
    for place, _, names in os.walk(folder):
        for name in names:
            with suppress(OSError):
                total += Path(place, name).stat().st_size
    return total


def _graphviz() -> Finding:
    found = shutil.which("dot")
    if found is None:
        remedy = "apt-get install graphviz (brew install graphviz), for `bgc graph`"
        return Finding("Graphviz", Health.OPTIONAL, "no `dot`", remedy)
    return Finding("Graphviz", Health.GOOD, found)


def _extras() -> Iterator[Finding]:
    """Examine the packages of each extra in `_EXTRAS`."""
    optional = re.compile(r'([\w.-]+).*extra == "(\w+)"')
    needed = [match for text in requires(_DISTRIBUTION) or () if (match := optional.match(text))]
    for extra, use in _EXTRAS.items():
        names = [match[1] for match in needed if match[2] == extra]
        try:
            found = ", ".join(f"{name} {version(name)}" for name in names)
        except PackageNotFoundError:
            remedy = f'pip install "{_DISTRIBUTION}[{extra}]", for {use}'
            yield Finding(extra, Health.OPTIONAL, "not installed", remedy)
        else:
            yield Finding(extra, Health.GOOD, found)
