"""The Windows binary of an FMU, run under Wine: `python tests/bench/windows_fmu.py [FILE ..]`.

Needs ziglang, which builds the binary and its host (windows_fmu.c), and `wine` (Debian: `apt-get
install wine wine64`). Prints the largest difference of the outputs from the Linux binary.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import fmpy
import numpy as np

ROOT = Path(__file__).parents[2]
SCENES = ("examples/two_mass", "examples/rectifier", "examples/stick_slip", "scenes/ur5",
          "scenes/knuckle_boom_hydraulic")  # fmt: skip
ZIG = [sys.executable, "-m", "ziglang", "cc"]
STEPS = 200


def main() -> None:
    """Print a row for each file."""
    files = [Path(name) for name in sys.argv[1:]]
    with tempfile.TemporaryDirectory() as work:
        folder = Path(work)
        source = str(Path(__file__).with_suffix(".c"))
        hosts = {"linux64": folder / "host", "win64": folder / "host.exe"}
        build = (["cc"], [*ZIG, "-target", "x86_64-windows-gnu"])
        for compiler, host in zip(build, hosts.values(), strict=True):
            subprocess.run([*compiler, "-O2", source, "-o", str(host)], check=True)
        for file in files or [ROOT / "library" / f"{name}.bg" for name in SCENES]:
            print(f"{file.stem:24} {compared(file, folder, hosts)}", flush=True)


def compared(file: Path, folder: Path, hosts: dict[str, Path]) -> str:
    """Build the binaries, run them, and compare their rows."""
    command = ["bgc", "build", str(file), "--target", "fmu2", "--platforms", "linux64,win64"]
    done = subprocess.run([*command, "-o", str(folder)], check=True, capture_output=True, text=True)
    place = Path(fmpy.extract(done.stdout.splitlines()[0], unzipdir=str(folder / file.stem)))
    description = fmpy.read_model_description(str(place))
    outputs = [str(v.valueReference) for v in description.modelVariables if v.causality == "output"]
    experiment = description.defaultExperiment
    step = str(float(experiment.stopTime) / STEPS)
    rows = {}
    for platform, ending in (("linux64", "so"), ("win64", "dll")):
        library = place / "binaries" / platform / f"{description.modelName}.{ending}"
        program = [*(["wine"] if ending == "dll" else []), str(hosts[platform]), str(library)]
        arguments = [description.guid, step, str(STEPS), *outputs]
        run = subprocess.run([*program, *arguments], check=True, capture_output=True, text=True)
        bits = [[int(word, 16) for word in line.split()] for line in run.stdout.splitlines()]
        rows[platform] = np.array(bits, dtype=np.uint64).view(float)
    linux, windows = rows["linux64"], rows["win64"]
    if np.array_equal(linux.view(np.uint64), windows.view(np.uint64)):
        return f"{linux.size} numbers, equal bits"
    span = np.maximum(np.ptp(linux, axis=0), 1e-300)
    worst = (np.abs(windows - linux).max(axis=0) / span).max()
    return f"{linux.size} numbers, differ by {worst:.0e} of an output's range"


if __name__ == "__main__":
    main()
