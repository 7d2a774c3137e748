"""The hydraulic knuckle-boom crane, on a quay and at sea: a fixed step of each over one of the
paper's crane, and its accuracy.

`python tests/bench/hydraulic.py`. The scenes are emitted as C programs, compiled with the same
flags (those of x86-64-v3, which valgrind knows), and run in steps of 1 ms for 15 s.
Per step: instructions by callgrind, where it is installed, of the run alone, and processor time,
the least of nine runs, in turn. Errors are those of the strokes against rodas5p at 1e-9, which
radau5 at 1e-8 confirms. Beside it, `cut_crane.py` runs the crane cut into two FMUs. The goals: a
step at most 0.7 of that of the paper's crane, 1.2 with vessel, waves, rope and load, 1 mm at 1 ms,
0.05 mm at a tolerance of 1e-4 in at most 1,000 steps.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import cut_crane
import numpy as np

import bgc
import bgc.library

SCENES = Path(bgc.library.__path__[0]) / "scenes"
FLAGS = ("-O2", "-march=x86-64-v3", "-std=gnu11")
PROGRAMS = (
    ("knuckle_boom_hydraulic", "ros23"),
    ("knuckle_boom_at_sea", "ros23"),
    ("two_beam_crane", "ros34prw"),
)
DURATION, STEP = 15.0, 1e-3
MAIN = """
#include "model.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}
int main(int argc, char **argv) {
    const bgc_model *m = bgc_get_model();
    bgc_data *d = bgc_new(m);
    bgc_options o;
    size_t done = 0;
    double end = argc > 2 ? atof(argv[2]) : 0.0;
    double *row = malloc(((size_t)m->n_output + 4) * sizeof *row);
    memset(&o, 0, sizeof o);
    o.name = argv[1];
    o.step = 1e-3;
    if (bgc_reset(m, d, 0.0) || bgc_set_options(m, d, &o)) {
        return 1;
    }
    double begun = now();
    if (end > 0.0 && bgc_run(m, d, &end, 1, row, &done)) {
        return 2;
    }
    printf("%ld %.9g\\n", bgc_get_counts(d)->steps, now() - begun);
    return 0;
}
"""


def program(folder: Path, scene: str, file: str) -> Path:
    """A program that runs a scene by a method for a time."""
    here = folder / scene
    here.mkdir()
    command = ("bgc", "build", SCENES / file, "--scene", scene, "--target", "c", "-o", here)
    subprocess.run(command, check=True, capture_output=True)
    (source,) = here.glob("*.c")
    (header,) = here.glob("*.h")
    (here / "main.c").write_text(MAIN.replace("model.h", header.name), "utf-8")
    made = here / "program"
    subprocess.run(("gcc", *FLAGS, here / "main.c", source, "-o", made, "-lm"), check=True)
    return made


def steps_and_seconds(made: Path, method: str) -> tuple[int, float]:
    """Steps and processor time, s, of one run."""
    run = subprocess.run((made, method, str(DURATION)), check=True, capture_output=True, text=True)
    steps, seconds = run.stdout.split()
    return int(steps), float(seconds)


def instructions(made: Path, method: str, until: float) -> int:
    """Instructions of the whole program, by callgrind."""
    command = ("valgrind", "--tool=callgrind", f"--callgrind-out-file={made}.cg")
    run = subprocess.run(
        (*command, made, method, str(until)), check=True, capture_output=True, text=True
    )
    found = re.search(r"Collected : (\d+)", run.stderr)
    assert found
    return int(found[1])


def steps() -> None:
    """Print the cost of a step of both cranes, and their ratio."""
    with tempfile.TemporaryDirectory() as name:
        made = {scene: program(Path(name), scene, f"{scene}.bg") for scene, _ in PROGRAMS}
        seconds = {scene: np.inf for scene, _ in PROGRAMS}
        counted = {}
        for _ in range(9):
            for scene, method in PROGRAMS:
                taken, spent = steps_and_seconds(made[scene], method)
                counted[scene] = taken
                seconds[scene] = min(seconds[scene], spent / taken)
        costs = []
        for scene, method in PROGRAMS:
            text = f"{scene:24} {method:9} {counted[scene]:6} steps {1e6 * seconds[scene]:6.2f} us"
            if shutil.which("valgrind"):
                run = instructions(made[scene], method, DURATION)
                costs.append((run - instructions(made[scene], method, 0.0)) / counted[scene])
                text += f" {costs[-1]:9,.0f} instructions"
            print(text)
        last = PROGRAMS[-1][0]
        for k, (scene, _) in enumerate(PROGRAMS[:-1]):
            ratio = f"{costs[k] / costs[-1]:.2f} in instructions, " if costs else ""
            time = seconds[scene] / seconds[last]
            print(f"a step of {scene} over that of the paper's crane: {ratio}{time:.2f} in time")


def accuracy(scene: str) -> None:
    """Print the errors of the strokes of a scene."""
    model = bgc.compile(SCENES / f"{scene}.bg", scene=scene)
    print(scene)
    reference = model.simulate(solver="rodas5p", rtol=1e-9, error=False)
    ways = (
        ("radau5", {"rtol": 1e-8}),
        *((method, {"step": STEP}) for method in ("ros23", "rodas23w", "ros34prw", "lie")),
        ("rodas5p", {"rtol": 1e-4}),
        ("rodas4p2", {"rtol": 1e-4}),
    )
    for solver, options in ways:
        run = model.simulate(solver=solver, error=False, **options)
        error = np.abs(run["stroke"] - reference["stroke"]).max()
        counts = run.counts
        print(
            f"{solver:9} {options} stroke {1e3 * error:8.1e} mm, {counts['steps']:.0f} steps, "
            f"{counts['rejected']:.0f} rejected, {counts['events']:.0f} events, "
            f"{run.time[-1] / counts['run_seconds']:,.0f} x real time"
        )


if __name__ == "__main__":
    steps()
    for scene in ("knuckle_boom_hydraulic", "knuckle_boom_at_sea"):
        accuracy(scene)
    cut_crane.main()
