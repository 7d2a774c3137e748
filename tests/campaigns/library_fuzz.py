"""Each parameter of each part of the library at the ends of its range and far beyond.

Every part runs in the small scene that `physics/library_parts.py` builds from its ports. One
parameter at a time takes the ends of its range, zero, minus its default, and 1e-9 and 1e9 times
its default. A run has to end with finite results and closed accounts, or be refused with a code; a
value that is refused before the run has to be refused by the name of its parameter.

    python tests/campaigns/library_fuzz.py [PART ..]
"""

from __future__ import annotations

import json
import os
import re
import select
import signal
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "physics"))

from library_parts import harness, parts

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.model import Model

COMPILE_SECONDS = 300
RUN_SECONDS = 10  # of silence: such a run is slow
DURATION = 0.1
RESIDUAL = 1e-4  # of the energy that was exchanged


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


def verdict(model: Model, name: str, value: float) -> tuple[str, str]:
    """The outcome of one run and what is said of it."""
    try:
        result = model.simulate(DURATION, rtol=1e-6, parameters={name: value})
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


def _work(part: str, first: int, out) -> None:
    """Write one line for each case of a part, from number `first` on."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{part}.bg"
        file.write_text(harness(part))
        try:
            model = bgc.compile(file)
        except BgError as error:
            print(json.dumps(("compile", 0.0, "uncompiled", str(error))), file=out, flush=True)
            return
        print(json.dumps(("compile", 0.0, "compiled", "")), file=out, flush=True)
        for name, value in cases(model)[first:]:
            print(json.dumps((name, value)), file=out, flush=True)
            print(json.dumps((name, value, *verdict(model, name, value))), file=out, flush=True)


def _lines(pipe: int) -> Iterator[str | None]:
    """Lines of a child as they come; None where it is silent for longer than it may be."""
    text, limit = b"", COMPILE_SECONDS
    while True:
        if not select.select([pipe], [], [], limit)[0]:
            yield None
            return
        more = os.read(pipe, 1 << 16)
        if not more:
            return
        *whole, text = (text + more).split(b"\n")
        limit = RUN_SECONDS
        for line in whole:
            yield line.decode()


def judged(part: str) -> Iterator[tuple[str, float, str, str]]:
    """All cases of a part; one that ends its process or is slow is followed by a new process."""
    done = 0
    while True:
        reading, writing = os.pipe()
        child = os.fork()
        if child == 0:
            os.close(reading)
            try:
                _work(part, done, os.fdopen(writing, "w"))
            finally:
                os._exit(0)
        os.close(writing)
        current: list = ["compile", 0.0]
        ending = "died"
        for line in _lines(reading):
            if line is None:
                os.kill(child, signal.SIGKILL)
                ending = "slow"
                break
            row = json.loads(line)
            if row[0] == "compile":
                current = []
                if row[2] != "compiled":
                    yield tuple(row)
            elif len(row) == 2:
                current = row
            else:
                current, done = [], done + 1
                yield tuple(row)
        os.waitpid(child, 0)
        os.close(reading)
        if not current:
            return
        yield (*current, ending, "")
        if current[0] == "compile":
            return
        done += 1


def main(names: list[str]) -> None:
    total: Counter[str] = Counter()
    for part in names or parts():
        found = Counter()
        for name, value, outcome, said in judged(part):
            found[outcome] += 1
            if outcome not in ("ran", "refused"):
                said = " ".join(said.split())
                print(f"  {outcome}: {part} {name} = {value:g}: {said[:400]}", flush=True)
        print(part, dict(found), flush=True)
        total += found
    print("total", dict(total))


if __name__ == "__main__":
    main(sys.argv[1:])
