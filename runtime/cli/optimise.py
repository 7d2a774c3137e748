"""Run 6: find the parameters that make an observable least or largest."""

from typing import Literal

from bgc.runtime.cli.command import command, option, require
from bgc.runtime.cli.options import PICTURE, TABLE, MethodOptions, SceneOptions
from bgc.runtime.cli.printing import AT_FAULT, attempt, report

_EPILOG = """\b
Examples (tuned.bg: the manual, "Many runs"):
  bgc optimise tuned.bg --vary "stiffness=10..400 N/m" \\
      --minimise "peak(speed)" --require "peak(stretch) < 0.1 m"
  bgc optimise tuned.bg --vary "stiffness=10..400 N/m" \\
      --vary "damping=1..50 N*s/m" --minimise "peak(speed) from 5 s" \\
      --over "mass=1..3 kg:5" --plot way.png
  bgc optimise tuned.bg --vary "stiffness=10..400 N/m" --runs 200 \\
      --maximise "above(speed, 0.1 m/s)"
"""


@command(epilog=_EPILOG)
def optimise(
    scene: SceneOptions,
    *,
    varied: tuple[str, ...] = option(
        'Parameter of the design, with its bounds: "k=50..500 N/m". May be repeated.',
        "--vary",
        metavar="RANGE",
        required=True,
    ),
    minimise: str | None = option('Objective: "max(load.z)", "rms(x) from 5 s".'),
    maximise: str | None = option("Objective to be made as large as possible."),
    criteria: tuple[str, ...] = option(
        'Limit: "max(pressure) < 210 bar". May be repeated; by default the limits of the scene.',
        "--require",
    ),
    over: tuple[str, ...] = option(
        'Run each design with these values of a parameter: "seed=1, 2, 3". May be repeated.',
        metavar="VALUES",
    ),
    judge: Literal["worst", "mean"] = option(
        "With --over: take the objective of the worst case, or the mean.", default="worst"
    ),
    search: Literal["gradient", "evolution"] | None = option(
        "gradient where the observables have derivatives, else evolution."
    ),
    starts: int = option(
        "Start at the best of N designs within the bounds.",
        within=(1, None),
        default=1,
        metavar="N",
    ),
    runs: int = option(
        "End after N runs with the best design so far; 10,000 by default.",
        within=(1, None),
        default=10_000,
        metavar="N",
    ),
    seed: int = option("Seed of the starts and of the evolution.", default=0),
    out: str | None = option("Write the design, its objective and limits: .csv.", type=TABLE),
    plot: str | None = option(
        "Draw the best objective against the runs: .png, .svg or .pdf.", type=PICTURE
    ),
    method: MethodOptions,
    quiet: bool = option("Print no progress.", "--quiet", "-q"),
) -> int:
    """Find the parameters of a scene of FILE that make an observable least or largest.

    Searches within bounds and limits, and prints the best design. The exit status is 1 if no
    design meets the limits or the search did not converge. Ctrl-C ends the search with the
    best design so far.
    """
    require(
        (minimise is None) != (maximise is None),
        'give either --minimise "max(NAME)" or --maximise "max(NAME)"',
    )
    model = scene.model(quiet)
    found, status = attempt(
        lambda: model.optimise(
            varied, minimise=minimise, maximise=maximise, require=criteria or None, over=over,
            judge=judge, search=search, starts=starts, runs=runs, seed=seed, progress=not quiet,
            **method.arguments,
        )
    )  # fmt: skip
    report(found, found.tables(), out, plot)
    return status or (0 if found.converged and found.feasible else AT_FAULT)
