"""Run 7: find the sea states in which criteria hold, and the downtime."""

from itertools import islice
from typing import Literal

from bgc.runtime.cli.command import Target, command, option
from bgc.runtime.cli.options import (
    PICTURE,
    SECONDS,
    TABLE,
    MethodOptions,
    SceneOptions,
    Scheduler,
)
from bgc.runtime.cli.printing import AT_FAULT, attempt, print_diagnostics, report
from bgc.runtime.studies.operability_result import read_scatter

_SHOWN = 3  # failures

_EPILOG = """\b
Example (lift.bg and north_sea.csv: the manual, "Operability"):
  bgc operability lift.bg --height "sea.height=1..5 m:3" \\
      --period "sea.period=5..13 s:5" --seed "sea.seed=1..4:4" \\
      --require "max(tension) < 350 kN" \\
      --require "peak(speed) from 20 s < 3 m/s" --exposure "3 h" \\
      --scatter north_sea.csv --plot map.png
"""


@command(epilog=_EPILOG)
def operability(
    scene: SceneOptions,
    *,
    height: str = option('Heights: "vessel.sea.height=1..4 m:7".', metavar="VALUES"),
    period: str = option('Periods: "vessel.sea.period=5..13 s:5".', metavar="VALUES"),
    heading: str | None = option('Headings: "vessel.sea.heading=90, 180 deg".', metavar="VALUES"),
    seed: str | None = option('Seeds: "vessel.sea.seed=1..10:10".', metavar="VALUES"),
    criteria: tuple[str, ...] = option(
        'Criterion: "max(tension) < 300 kN", "min(clearance) from 20 s > 1 m". May be '
        "repeated; by default the limits of the scene.",
        "--require",
    ),
    judge: Literal["gumbel", "worst"] = option(
        "Extreme over the seeds: the most probable one, or that of the worst seed.",
        default="gumbel",
    ),
    exposure: float | None = option('Time for which extremes are to hold: "3 h".', type=SECONDS),
    scatter: str | None = option("Scatter diagram (CSV), for the downtime.", metavar="FILE"),
    out: str | None = option("Write all cells and criteria: .csv.", type=TABLE),
    plot: str | None = option("Draw the maps: .png, .svg or .pdf.", type=PICTURE),
    store: str | None = option(
        "Zarr group for all runs (.zarr), resumable.", type=Target(".zarr"), metavar="DIR"
    ),
    scheduler: Scheduler,
    method: MethodOptions,
    quiet: bool = option("Print no progress bar.", "--quiet", "-q"),
) -> int:
    """Find the sea states in which criteria hold: height x period x heading x seed.

    Prints the governing criterion of each sea state, the limiting height of each period, and the
    downtime for a scatter diagram. A sea state with a failed run is not operable;
    the exit status is then 1.
    """
    diagram = read_scatter(scatter) if scatter is not None else None
    model = scene.model(quiet)
    found, status = attempt(
        lambda: model.operability(
            height, period, criteria, heading=heading, seed=seed, judge=judge, exposure=exposure,
            store=store, scheduler=scheduler, progress=not quiet, resume=True, **method.arguments,
        )
    )  # fmt: skip
    if status:
        return status
    print_diagnostics(islice(found.study.placed_failures(), _SHOWN))
    tables = found.tables()
    if diagram is not None:
        tables.append(found.downtime_table(found.downtime(diagram)))
    report(found, tables, out, plot, store)
    return AT_FAULT if found.study.failures else 0
