"""Preview builds: compiled quickly without optimisation, for a model that is being edited.

The model's units are compiled by `tcc` where it is installed (hundredths of a second), otherwise by
the usual compiler at -O0. The optimised runtime is used as it is: it is in the cache after the
first build of any model.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import replace

from bgc.building.build import Unit
from bgc.building.toolchain import Toolchain, identify, try_compiler

_FLAGS = ("-O0", "-std=c11", "-fPIC")


def previewed(units: Sequence[Unit]) -> tuple[Unit, ...]:
    """The same units, with compilers and flags for a quick build."""
    quick = _quick_compiler()
    if quick is None:
        return tuple(replace(unit, flags=_FLAGS) for unit in units)
    return tuple(
        replace(unit, text=_without_negative_infinity(unit.text), flags=_FLAGS, compiler=quick)
        if not unit.files
        else replace(unit, flags=_FLAGS)  # tcc 0.9.27 cannot include binary files
        for unit in units
    )


def _quick_compiler() -> Toolchain | None:
    """Find tcc; None where it is absent or cannot make a shared object."""
    if shutil.which("tcc") is None:
        return None
    toolchain = identify(("tcc",))
    return None if try_compiler(toolchain, _FLAGS) else toolchain


def _without_negative_infinity(text: str) -> str:
    """Rewrite tables for tcc 0.9.27, which does not accept a negated infinity as a constant."""
    return text.replace("-INFINITY", "-1.0 / 0.0")
