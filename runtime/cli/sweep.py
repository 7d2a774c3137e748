"""Run 4: simulate a scene for many values of its parameters."""

from itertools import islice
from pathlib import Path

import numpy as np

from bgc.diagnostics.diagnostic import BgError
from bgc.printing.text_tables import Table
from bgc.runtime.cli.command import Target, command, option, require
from bgc.runtime.cli.options import PICTURE, MethodOptions, SceneOptions, Scheduler
from bgc.runtime.cli.printing import (
    AT_FAULT,
    attempt,
    print_diagnostics,
    print_tables,
    print_text,
    print_written,
    save,
)
from bgc.runtime.model import Model
from bgc.runtime.results.ensemble import Ensemble
from bgc.runtime.results.observables import STEPPED
from bgc.runtime.results.study import Study
from bgc.runtime.results.study_kinds import STUDY_KINDS
from bgc.runtime.running.parameter_grid import DESIGNS
from bgc.runtime.studies.sweep import Design, check_reports

_SHOWN = 3  # failures, and warnings of instances

_EPILOG = """\b
Examples (tuned.bg: the manual, "Many runs"):
  bgc sweep tuned.bg --vary "mass=1..9 kg:20" --out rows.csv
  bgc sweep tuned.bg --vary "mass=1, 2, 4 kg" --observe "max(speed)" \\
      --vary "stiffness=10..1e3 N/m:7 log" --plot map.png
  bgc sweep tuned.bg --vary "mass=1..9 kg" --vary "damping=1..9 N*s/m" \\
      --sample 64 --design saltelli --observe "rms(speed) from 5 s" --rank
  bgc sweep tuned.bg --cases cases.csv --observe "rms(speed)" --out study.zarr
"""


@command(epilog=_EPILOG)
def sweep(
    scene: SceneOptions,
    *,
    varied: tuple[str, ...] = option(
        'Values of a parameter: "boom.mass=5..9 t:20" for 20 values, "k=1..100 N/m:5 log", '
        '"seed=1, 2, 5". May be repeated.',
        "--vary",
        metavar="VALUES",
    ),
    cases: str | None = option("CSV file with a column for each parameter.", metavar="FILE"),
    sample: int | None = option(
        "Take N points spread over all ranges instead of all combinations.",
        within=(1, None),
        metavar="N",
    ),
    design: str = option(
        "How --sample spreads them; saltelli (N base points) is for Sobol indices.",
        choices=DESIGNS,
        default="latin",
    ),
    seed: int = option("Seed of the sample; 0 by default.", default=0),
    observed: tuple[str, ...] = option(
        'Keep this number of each run, and no rows: "max(tension)", "quantile(x, 0.95)", '
        '"rms(heave) from 20 s". May be repeated.',
        "--observe",
    ),
    rank: bool = option("Rank the parameters by their influence."),
    out: str | None = option(
        "File to write: .csv, .npz, .zarr (a directory, resumable), or - for standard output.",
        type=Target(".csv", ".npz", ".zarr", "-"),
    ),
    plot: str | None = option("Draw the observables, or all rows: .png, .svg, .pdf.", type=PICTURE),
    kind: str | None = option("Kind of the plot of observables.", choices=STUDY_KINDS),
    scheduler: Scheduler,
    method: MethodOptions,
    quiet: bool = option("Print no summary and no progress bar.", "--quiet", "-q"),
) -> int:
    """Simulate a scene of FILE for many values of its parameters.

    Runs all combinations of the values, or N points among them (--sample), several at once.
    After Ctrl-C or SIGTERM the instances that are done are written; the same command then
    computes the others.
    """
    require(varied or cases is not None, 'give --vary "NAME=LOW..HIGH", or --cases FILE')
    require(observed or out or plot, 'give --out FILE, --plot FILE or --observe "max(NAME)"')
    require(observed or not (rank or kind), '--rank and --kind need --observe "max(NAME)"')
    require(plot or not kind, "--kind needs --plot FILE")
    store = out if out is not None and Path(out).suffix.lower() == ".zarr" else None
    model = scene.model(quiet)
    check_reports(model, Design(varied, sample, design, seed, cases), kind, rank)
    found, status = attempt(
        lambda: model.sweep(
            varied, observed, **method.arguments, sample=sample, design=design, seed=seed,
            cases=cases, scheduler=scheduler, store=store, progress=not quiet, resume=True,
        ),
        "interrupted before the first instance: nothing is written",
    )  # fmt: skip
    _print_warnings(found)
    save(found, None if store else out)
    drawn = plot if not status or found.status.count("done") else None
    if drawn is not None:
        found.plot(drawn, **({"kind": kind} if kind else {}))
    tables: list[Table] = []
    if not quiet:
        print_text(_summary(found), err=out == "-")
        tables += found.statistics().tables() if observed and out != "-" else []
    if rank:
        tables += found.sensitivity().tables(_local(model, found, method))
    print_tables(tables)
    if not quiet:
        print_written(out, drawn)
    return status or (AT_FAULT if found.failures else 0)


def _local(model: Model, found: Study, method: MethodOptions) -> dict[str, dict[str, str]]:
    """The effects of the varied parameters at their present values, where there are any."""
    smooth = [name for name in found.names if not name.startswith(STEPPED)]
    present = [name for name in found.parameters if model.parameters[name].value]
    try:
        effects = model.effects(smooth, of=present, **method.arguments) if smooth else None
    except BgError:
        return {}
    return {name: effects.texts(name) for name in smooth} if effects else {}


def _print_warnings(found: Ensemble | Study) -> None:
    """Print the warnings, and the first failures and warnings of instances."""
    placed = [found.placed_failures()]
    if isinstance(found, Ensemble):
        placed.append(found.placed_warnings())
    shown = (diagnostic for each in placed for diagnostic in islice(each, _SHOWN))
    print_diagnostics((*found.warnings, *shown))


def _summary(found: Ensemble | Study) -> str:
    """Count the instances by their status, and say how they were run."""
    counts = {name: found.status.count(name) for name in dict.fromkeys(found.status)}
    ended = ", ".join(f"{count} {name}" for name, count in counts.items())
    values = found.values[found.done]
    undefined = np.count_nonzero(~np.isfinite(values).all(axis=tuple(range(1, values.ndim))))
    ended += f"; {undefined} with values that are not finite" if undefined else ""
    earlier = f"; {found.recalled} of them before" if found.recalled else ""
    alone = f"; one by one: {found.alone}" if found.alone else ""
    return f"{ended}{earlier}{alone}"
