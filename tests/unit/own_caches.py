"""Caches of tests' own that hold the compiled runtime: it takes 20 times as long as a model."""

import shutil
from pathlib import Path

from bgc.building.build import _shared_key, _unit_key, compile_runtime, shared_runtime_units
from bgc.building.cache import open_cache
from bgc.building.toolchain import Compilations, find_toolchain


def with_runtime(root: Path) -> Path:
    """Copy the objects that all models need from the usual cache to a new one at `root`."""
    usual, toolchain = open_cache(), find_toolchain()
    compile_runtime(toolchain, usual, Compilations())
    own = root / "objects"
    own.mkdir(parents=True)
    shared = _shared_key(toolchain)
    for unit in shared_runtime_units():
        for suffix in (".o", ".o.sum"):
            shutil.copy2(usual.root / "objects" / f"{_unit_key(shared, unit)}{suffix}", own)
    return root
