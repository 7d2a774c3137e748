"""Measure 3: drive a scene to its extremes, and map where it fails."""

from bgc.language.solver import Solver
from bgc.runtime.cli.command import command, option, require
from bgc.runtime.cli.options import (
    PICTURE,
    TABLE,
    Budget,
    Duration,
    Json,
    SceneOptions,
    option_of,
)
from bgc.runtime.cli.printing import (
    AT_FAULT,
    MEASUREMENTS_KEPT,
    attempt,
    print_tables,
    print_text,
    print_written,
)
from bgc.runtime.stress.stress import stress as stress_map
from bgc.runtime.stress.stress_tables import as_json, summary, tables, write_csv


@command()
def stress(
    scene: SceneOptions,
    *,
    drives: tuple[str, ...] = option(
        'Parameter and its values, as for sweep: "k=1e3..1e14 N/m", "step=1 us..0.1 s:11 log", '
        '"rtol=1e-3, 1e-6", "*.lock.stiffness=.." for several at once. May be repeated; by '
        "default all are driven.",
        "--drive",
        metavar="NAME=LOW..HIGH",
    ),
    grid: bool = option("Drive two --drive together, over all pairs of their values."),
    solver: str | None = option_of(
        Solver, "name", "Method to judge; by default that of the scene."
    ),
    rtol: float | None = option_of(Solver, "rtol", "Relative tolerance of the method."),
    step: float | None = option_of(Solver, "step", "Step of the method."),
    duration: Duration,
    within: float | None = option(
        "Largest acceptable error, as a fraction of the range of a result."
    ),
    budget: Budget,
    fresh: bool = option("Discard earlier results."),
    out: str | None = option("Write the results: .csv.", type=TABLE),
    plot: str | None = option("Draw the map: .png, .svg or .pdf.", type=PICTURE),
    json: Json,
    quiet: bool = option("Print the totals only.", "--quiet", "-q"),
) -> int:
    """Drive a scene of FILE to its extremes; map where it holds and fails.

    Varies stiffnesses, inertias, resistances, sources and angles through their ranges, and the
    step, the tolerance and the simulated time. Compares each run with other methods. Re-running
    resumes where Ctrl-C or the budget ended it. The exit status is 1 where results are wrong
    without an error or a warning.
    """
    require(not grid or len(drives) == 2, "--grid takes two --drive")
    model = scene.model(quiet)
    found, _ = attempt(
        lambda: stress_map(
            model,
            drives,
            grid=grid,
            solver=solver,
            rtol=rtol,
            step=step,
            duration=duration,
            within=within,
            budget=budget,
            fresh=fresh,
            progress=not quiet,
        ),
        MEASUREMENTS_KEPT,
    )
    if json:
        print_text(as_json(found))
    elif quiet:
        print_text(summary(found))
    else:
        print_tables(tables(found))
    if out is not None:
        write_csv(found, out)
    if plot is not None:
        # Loads matplotlib.
        from bgc.runtime.stress.stress_plot import draw

        draw(found, plot)
    if not (quiet or json):
        print_written(out, plot)
    return AT_FAULT if found.wrong else 0
