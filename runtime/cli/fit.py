"""Run 5: estimate parameters from a recorded motion."""

from typing import Literal

from bgc.runtime.cli.command import command, option, require
from bgc.runtime.cli.options import PICTURE, TABLE, MethodOptions, SceneOptions, assigned
from bgc.runtime.cli.printing import AT_FAULT, attempt, report

_EPILOG = """\b
Examples (tuned.bg and shaken.csv: the manual, "Many runs"):
  bgc fit tuned.bg --data shaken.csv --vary "stiffness=50..500 N/m" \\
      --vary "damping=0..50 N*s/m"
  bgc fit tuned.bg --data shaken.csv --vary "stiffness=1..1e4 N/m" \\
      --starts 16 --noise "stretch=1 mm" --loss huber --plot fit.png
"""


@command(epilog=_EPILOG)
def fit(
    scene: SceneOptions,
    *,
    data: str = option(
        "CSV file of the recorded motion: columns `time` and observed ones, `x [mm]`.",
        metavar="FILE",
    ),
    varied: tuple[str, ...] = option(
        'Parameter to estimate, with its bounds: "k=1..1000 N/m". May be repeated.',
        "--vary",
        metavar="RANGE",
        required=True,
    ),
    matches: tuple[tuple[str, str], ...] = option(
        "A column of the file with another name than the scene's. May be repeated.",
        "--match",
        type=assigned('--match "position=x"'),
        metavar="OBSERVED=RECORDED",
    ),
    noises: tuple[tuple[str, str], ...] = option(
        'Standard deviation of a column: "position=1 mm". Estimated by default.',
        "--noise",
        type=assigned('--noise "x=2 mm"'),
    ),
    loss: Literal["linear", "soft_l1", "huber", "cauchy"] = option(
        "linear: least squares; the others bear outliers.", default="linear"
    ),
    starts: int = option(
        "Start at the best of N points within the bounds.",
        within=(1, None),
        default=1,
        metavar="N",
    ),
    confidence: float = option("Level of the confidence intervals; 0.95 by default.", default=0.95),
    out: str | None = option("Write estimates and intervals: .csv.", type=TABLE),
    plot: str | None = option("Draw data and estimate: .png, .svg or .pdf.", type=PICTURE),
    method: MethodOptions,
) -> int:
    """Estimate parameters of a scene of FILE from a recorded motion.

    Minimises the squares of computed less recorded values within bounds. Prints the estimates
    with their confidence intervals, and warns of parameters that the data do not determine.
    """
    given = dict(method.arguments)
    times = given.pop("duration"), given.pop("every")
    require(not any(times), "the data give the times: omit --time and --every")
    model = scene.model()
    match = {recorded: observed for observed, recorded in matches}
    estimate, _ = attempt(
        lambda: model.fit(
            data, varied, match=match, noise=dict(noises), loss=loss, starts=starts,
            confidence=confidence, **given,
        ),
        "interrupted before the estimate was found: nothing is written",
    )  # fmt: skip
    report(estimate, estimate.tables(), out, plot)
    return 0 if estimate.converged else AT_FAULT
