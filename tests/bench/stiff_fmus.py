"""A stiff model in FMUs, side by side: `python tests/bench/stiff_fmus.py [REFERENCE_FMUS]`.

Van der Pol's oscillator at mu = 1000 over 2,000 s, of the Test Set for IVP Solvers, whose published
end is the reference. Driven by FMPy: our FMU in Co-Simulation with its own solver and in Model
Exchange with FMPy's CVode and Euler, and `VanDerPol` of the Modelica Association's Reference FMUs,
which integrates by Euler with steps of 10 ms in Co-Simulation. For that row give the folder of

    git clone https://github.com/modelica/Reference-FMUs
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

MODEL = """
model VanDerPol {
  param mu = 1000;
  state x = 2;
  state v = 0;
  der(x) = v;
  der(v) = mu*(1 - x^2)*v - x;
}
scene stiff of VanDerPol { observe x; solver rodas5p(rtol = 1e-6); run 2000 s every 1 s; }
"""
END, WANTED = 2000.0, 1.7061677321704  # x there: Test Set for IVP Solvers, problem VDPOL
EULER = 5e-4  # s; 1/3000 s is the fastest time constant, so 10 ms is 15 times beyond the limit
SHARE = 0.01  # of the end, which Euler's short steps are run for


def main() -> None:
    """Print the table."""
    reference = Path(sys.argv[1]) if len(sys.argv) > 1 else None
    with tempfile.TemporaryDirectory() as work:
        folder = Path(work)
        ours = our_fmu(folder)
        row("ours, CS, steps of 1 s", lambda: co_simulation(ours, 1.0))
        row("ours, CS, one step of 2,000 s", lambda: co_simulation(ours, END))
        row("ours, ME, CVode of FMPy at 1e-6", lambda: model_exchange(ours, "CVode", None, END))
        row("ours, ME, Euler of FMPy, 10 ms", lambda: model_exchange(ours, "Euler", 1e-2, 10.0))
        row(
            f"ours, ME, Euler of FMPy, 0.5 ms, {SHARE:.0%} of it",
            lambda: model_exchange(ours, "Euler", EULER, SHARE * END),
        )
        if reference is None:
            print("Reference FMU: not measured, its folder was not given")
            return
        theirs = reference_fmu(reference, folder)
        row("Reference FMU, CS, steps of 1 s", lambda: co_simulation(theirs, 1.0, mu=1000.0))


def row(name: str, call: Callable[[], tuple[float, float, str]]) -> None:
    """Print the end value, its error at 2,000 s, the FMU's report and the processor time."""
    begun = time.process_time()
    t, x, report = call()
    spent = time.process_time() - begun
    error = f"{abs(x - WANTED):.1e}" if t == END else "-"
    print(f"{name:44} t = {t:6g} s  x = {x:10.6g}  error {error:8} {report:42} {spent:8.2f} s")


def co_simulation(path: str, step: float, **values: float) -> tuple[float, float, str]:
    """Step to the end; the report are the statuses of all steps."""
    folder = path if Path(path).is_dir() else fmpy.extract(path)
    description = fmpy.read_model_description(folder)
    references = {v.name: v.valueReference for v in description.modelVariables}
    fmu = FMU2Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="one",
    )
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    for name, value in values.items():
        fmu.setReal([references[name]], [value])
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    place = references.get("x0", references.get("x", 0))
    first_wrong, t, x = None, 0.0, 2.0
    for k in range(round(END / step)):
        fmu.doStep(k * step, step)  # raises unless the status is OK
        t = (k + 1) * step
        (x,) = fmu.getReal([place])
        if not np.isfinite(x) and first_wrong is None:
            first_wrong = t
    fmu.freeInstance()
    report = "OK" if first_wrong is None else f"OK, nan from {first_wrong:g} s on"
    return t, x, report


def model_exchange(
    path: str, solver: str, step: float | None, end: float
) -> tuple[float, float, str]:
    """Integrate by FMPy."""
    try:
        found = fmpy.simulate_fmu(
            path,
            fmi_type="ModelExchange",
            solver=solver,
            step_size=step,
            relative_tolerance=1e-6,
            stop_time=end,
            output_interval=step or 1.0,
        )
    except Exception as problem:
        return end, float("nan"), f"refused: {str(problem).partition(' (')[0]}"
    x = found["x"]
    return float(found["time"][-1]), float(x[-1]), "OK"


def our_fmu(folder: Path) -> str:
    """Export our model."""
    (folder / "van_der_pol.bg").write_text(MODEL)
    command = ["bgc", "build", "van_der_pol.bg", "--target", "fmu2"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return str(folder / "van_der_pol.fmu")


def reference_fmu(source: Path, folder: Path) -> str:
    """Build the Reference FMU from its sources, as its CMake file does."""
    place = folder / "reference"
    binaries = place / "binaries" / fmpy.platform
    binaries.mkdir(parents=True)
    text = (source / "VanDerPol" / "FMI2.xml").read_text()
    (place / "modelDescription.xml").write_text(text)
    files = [
        source / "VanDerPol/model.c",
        source / "src/fmi2Functions.c",
        source / "src/cosimulation.c",
    ]
    includes = [f"-I{source / 'include'}", f"-I{source / 'VanDerPol'}"]
    flags = ["-O2", "-fPIC", "-shared", "-DFMI_VERSION=2", "-DDISABLE_PREFIX"]
    command = [
        "cc",
        *flags,
        *includes,
        *map(str, files),
        "-o",
        str(binaries / "VanDerPol.so"),
        "-lm",
    ]
    subprocess.run(command, check=True)
    return str(place)


if __name__ == "__main__":
    main()
