"""Each parameter of each part of the library at the ends of its range and far beyond.

Every part runs in the small scene that `physics/library_parts.py` builds from its ports. One
parameter at a time takes the ends of its range, zero, minus its default, and 1e-9 and 1e9 times
its default. A run has to end with finite results and closed accounts, or be refused with a code; a
value that is refused before the run has to be refused by the name of its parameter.
"""

from __future__ import annotations

import re
import sys
from functools import cache
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "physics"))

from judging import Verdict
from library_parts import harness, parts

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.model import Model

PORTION = SIZE = 200  # numbers of the cases of a part, which has fewer
CPU_SECONDS = 60.0  # with the compilation of a part
MEMORY = 4_000_000_000  # bytes
DURATION = 0.1
RESIDUAL = 1e-4  # of the energy that was exchanged

groups = parts
"""The parts, each of which has the numbers of `SIZE` cases."""


def values(parameter) -> tuple[float, ...]:
    """The values that a parameter takes, without its default."""
    size = parameter.default or 1.0
    tried = [0.0, -size, 1e-9 * size, 1e9 * size]
    tried += [end for end in (parameter.low, parameter.high) if np.isfinite(end)]
    return tuple(v for v in dict.fromkeys(tried) if v != parameter.default)


def cases(model: Model) -> tuple[tuple[str, float], ...]:
    """Parameters of the part itself with their values; parts inside have harnesses of their own.

    Of a vector or matrix they are the first and the last component.
    """
    components: dict[str, list] = {}
    for parameter in model.parameters.values():
        if parameter.name.startswith("part.") and parameter.name.count(".") == 1:
            components.setdefault(parameter.name.split("[")[0], []).append(parameter)
    tried = [p for found in components.values() for p in dict.fromkeys((found[0], found[-1]))]
    return tuple((p.name, value) for p in tried for value in values(p))


@cache
def _compiled(part: str, folder: Path) -> Model | str:
    """The model around a part, or why there is none."""
    file = folder / f"{part}.bg"
    file.write_text(harness(part))
    try:
        return bgc.compile(file)
    except BgError as error:
        return str(error)


def text_of(seed: int, number: int) -> tuple[str, bytes]:
    """The scene around the part of a number."""
    del seed
    part = parts()[number // SIZE]
    return part, harness(part).encode()


def judge(seed: int, number: int, folder: Path) -> list[Verdict]:
    """The outcome of one value; one fault where the part does not compile."""
    del seed
    part, nth = parts()[number // SIZE], number % SIZE
    model = _compiled(part, folder)
    if isinstance(model, str):
        return [] if nth else [Verdict("unjust", (), f"{part}\n{model}")]
    tried = cases(model)
    if nth >= len(tried):
        return []
    name, value = tried[nth]
    outcome, said = verdict(model, name, value)
    return [Verdict(outcome, (), f"{part} {name} = {value:g}\n{said}")]


def verdict(model: Model, name: str, value: float) -> tuple[str, str]:
    """The outcome of one run and what is said of it."""
    try:
        result = model.simulate(DURATION, rtol=1e-6, parameters={name: value}, error=False)
    except BgError as error:
        said = str(error)
        plain = name.removeprefix("part.").split("[")[0]
        code = error.diagnostics[0].code if error.diagnostics else "?"
        if not code.startswith("BG"):
            return "uncoded", said
        named = plain in said
        ended = re.search(r"\bat t = (?!0 s)", said)
        return ("ended" if ended else "refused" if named else "unnamed"), said
    except Exception as error:  # whatever it is, it is a fault
        return "traceback", f"{type(error).__name__}: {error}"
    for column in result:
        if not np.isfinite(result[column]).all():
            return ("warned" if result.warnings else "not finite"), column
    left = float(np.abs(result["energy.residual"]).max())
    exchanged = result.counts.get("exchanged", 0.0)
    if not np.isfinite(left) or left > RESIDUAL * exchanged + 1e-12:
        return "open account", f"{left:.2e} of {exchanged:.2e}" + "; ".join(
            f" {w.code}" for w in result.warnings
        )
    return "ran", ""
