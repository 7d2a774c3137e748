"""Growth of compile time with the size of a model.

Rules: processor time of the whole command `bgc build --target c`, the least of three, for a small
and a large model of each family. The time of a model of one state, which is that of the imports, is
subtracted. The figure is the exponent of the size that leads from one time to the other.
"""

import math
import resource
import subprocess
import tempfile
from pathlib import Path

from growing import MODELS
from table import Row

RUNS = 3

ALONE = """
model Alone { store : C(1); loss : R(1); node : J0; node -> store, loss; }
scene s of Alone { observe store.q; run 1 s; }
"""

FAMILIES = {
    "chain": (200, 1000, 1.15),
    "motors": (100, 500, 1.2),
    "ladder": (100, 400, 1.2),
    "field": (25, 60, 2.2),
    "arm": (6, 20, 1.4),
}


def rows() -> list[Row]:
    """The exponent of each family, with the processor times of its two sizes."""
    least = seconds(ALONE)
    found = []
    for name, (small, large, must) in FAMILIES.items():
        times = [seconds(MODELS[name](n)) for n in (small, large)]
        exponent = math.log((times[1] - least) / (times[0] - least)) / math.log(large / small)
        note = f"{times[0]:.2f} s and {times[1]:.2f} s, imports {least:.2f} s"
        on = f"compile time, {small} to {large}"
        found.append(Row(name, on, exponent, must=must, below=True, note=note))
    return found


def seconds(text: str) -> float:
    """The least processor time of `bgc build --target c` of a model."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "model.bg").write_text(text, encoding="utf-8")
        command = ["bgc", "build", "model.bg", "--target", "c"]
        found = []
        for _ in range(RUNS):
            before = _children()
            subprocess.run(command, cwd=folder, check=True, capture_output=True)
            found.append(_children() - before)
    return min(found)


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
