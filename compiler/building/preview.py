"""Builds that are ready at once and run slowly: for a first look at a model that changes.

The units of the model go through `tcc` where it is installed, which takes hundredths of a second,
else through the usual compiler without optimisation. The runtime stays as it is: it is in the cache
after the first build of any model.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import replace

from bgc.building.build import Unit
from bgc.building.toolchain import Toolchain, identify, try_compiler

_FLAGS = ("-O0", "-std=c11", "-fPIC")


def previewed(units: Sequence[Unit]) -> tuple[Unit, ...]:
    """The same units, to be compiled fast."""
    quick = _quick_compiler()
    if quick is None:
        return tuple(replace(unit, flags=_FLAGS) for unit in units)
    return tuple(
        replace(unit, text=_without_negative_infinity(unit.text), flags=_FLAGS, compiler=quick)
        for unit in units
    )


def _quick_compiler() -> Toolchain | None:
    """tcc, where it is installed and makes shared objects."""
    if shutil.which("tcc") is None:
        return None
    toolchain = identify(("tcc",))
    return None if try_compiler(toolchain, _FLAGS) else toolchain


def _without_negative_infinity(text: str) -> str:
    """Tables as tcc 0.9.27 takes them: it does not see a constant in a negated infinity."""
    return text.replace("-INFINITY", "-1.0 / 0.0")
