"""The layers of the package: each module imports only what stands before it, and no circles.

Imports are read from the source, those inside functions and for type checking included.
"""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = {
    "bgc": "compiler",
    "bgc.grammar": "grammar",
    "bgc.library": "library",
    "bgc.runtime": "runtime",
}

# From the bottom up. A prefix stands for all its modules; the longest prefix counts.
LAYERS = """
bgc.record_class
bgc.diagnostics.source bgc.diagnostics.diagnostic bgc.diagnostics.words bgc.diagnostics.row
bgc.diagnostics.catalogue
bgc.diagnostics
bgc.grammar
bgc.library
bgc.options
bgc.algebra
bgc.values
bgc.language
bgc.ir
bgc.building.user_folder bgc.building.cache bgc.building.code_identity
bgc.resolution
bgc.elaboration.instances
bgc.elaboration.bonds
bgc.elaboration.laws
bgc.elaboration.scenes
bgc.elaboration
bgc.passivity
bgc.causality
bgc.equations.variables
bgc.equations.storage
bgc.equations.inertias
bgc.equations.motions
bgc.equations.loops
bgc.equations.start
bgc.equations
bgc.slicing
bgc.building
bgc.emission
bgc.driver
bgc.linearising
bgc.printing
bgc.symbolic
bgc.reference
bgc.editing
bgc.runtime.results
bgc.runtime.linear
bgc.runtime.running
bgc.runtime.documents
bgc.runtime.realtime
bgc.runtime.fmi
bgc.runtime.importing
bgc.runtime.linearising
bgc.runtime.measuring
bgc.runtime.activity
bgc.runtime.trade
bgc.runtime.stress
bgc.runtime.studies
bgc.runtime.reduced_parts
bgc.runtime.reduce
bgc.runtime.editor
bgc.runtime.view
bgc.runtime.web
bgc.runtime.targets
bgc.runtime
bgc.runtime.cli
bgc
"""
ORDER = {prefix: level for level, line in enumerate(LAYERS.split("\n")) for prefix in line.split()}


def modules() -> dict[str, Path]:
    found = {}
    for package, folder in FOLDERS.items():
        for path in (ROOT / folder).rglob("*.py"):
            parts = path.relative_to(ROOT / folder).with_suffix("").parts
            name = ".".join((package, *parts)).removesuffix(".__init__")
            found[name] = path
    return found


MODULES = modules()


def imports(path: Path) -> Iterator[tuple[str, int]]:
    """The modules of bgc that a file imports, with the line."""
    for node in ast.walk(ast.parse(path.read_text())):
        match node:
            case ast.ImportFrom(module=str(module)) if module.split(".")[0] == "bgc":
                for alias in node.names:
                    full = f"{module}.{alias.name}"
                    yield (full if full in MODULES else module), node.lineno
            case ast.Import():
                for alias in node.names:
                    if alias.name.split(".")[0] == "bgc":
                        yield alias.name, node.lineno


@cache
def all_imports() -> dict[str, tuple[tuple[str, int], ...]]:
    return {name: tuple(imports(path)) for name, path in MODULES.items()}


def level(module: str) -> int:
    parts = module.split(".")
    prefixes = (".".join(parts[:k]) for k in range(len(parts), 0, -1))
    return next(ORDER[prefix] for prefix in prefixes if prefix in ORDER)


def test_every_module_imports_only_what_stands_before_it():
    wrong = [
        f"{name}:{line} imports {imported}"
        for name, found in all_imports().items()
        for imported, line in found
        if level(imported) > level(name)
    ]
    assert not wrong, "\n".join(wrong)


def test_no_imports_run_in_a_circle():
    """Remove modules that import nothing that is left; what stays imports in a circle."""
    left = {name: {m for m, _ in found if m != name} for name, found in all_imports().items()}
    while leaves := {name for name, found in left.items() if not found & left.keys()}:
        left = {name: found for name, found in left.items() if name not in leaves}
    assert not left


@pytest.mark.parametrize("prefix", ORDER)
def test_every_layer_has_modules(prefix):
    assert any(name == prefix or name.startswith(f"{prefix}.") for name in MODULES)
