"""Measure 2: measure speed against accuracy, and recommend a method."""

import time

from bgc.runtime.cli.command import Target, Values, command, option
from bgc.runtime.cli.options import (
    PICTURE,
    SECONDS,
    TABLE,
    Deadline,
    Duration,
    SceneOptions,
    Within,
)
from bgc.runtime.cli.printing import (
    MEASUREMENTS_KEPT,
    attempt,
    print_sentence,
    print_tables,
    print_text,
    print_written,
    save,
)
from bgc.runtime.trade.configurations import KEEPS, RTOLS
from bgc.runtime.trade.trade import trade as measure_trade
from bgc.runtime.trade.trade_tables import tables

_LEAST_SHARE = 0.5  # of the budget, which compiling does not take


@command()
def trade(
    scene: SceneOptions,
    *,
    out: str | None = option("Write all measurements: .csv.", type=TABLE),
    plot: str | None = option(
        "Draw error against processor time: .png, .svg or .pdf.", type=PICTURE
    ),
    html: str | None = option("Write a page with table and plot: .html.", type=Target(".html")),
    solvers: str | None = option(
        "Methods to try: rodas5p,ros34prw; by default all.", metavar="NAMES"
    ),
    rtols: list[float] | None = option(
        "Tolerances of adaptive methods: 1e-3,1e-6.", type=Values(""), metavar="NUMBERS"
    ),
    steps: list[float] | None = option(
        'Steps of fixed-step methods: "1 ms, 0.5 ms".', type=Values("s"), metavar="TIMES"
    ),
    keeps: list[float] | None = option(
        "Numbers of steps for which a Jacobian is kept: 1,2,5.",
        "--keep",
        type=Values(""),
        metavar="NUMBERS",
    ),
    variants: tuple[str, ...] = option(
        'Variants to measure too: a slot to fill with other types ("*.lock": several slots '
        'together; "all": each slot by itself), "activity" (without the parts that bgc '
        'activity finds negligible), or lines of a scene: "use a = B; set c = 0".',
        metavar="VARIANT",
    ),
    within: Within,
    deadline: Deadline,
    faster_than: float | None = option("Least speed, as a multiple of real time.", metavar="N"),
    duration: Duration,
    budget: float = option(
        "Longest time for the measurements.",
        type=SECONDS,
        default="300 s",
        show_default=True,
    ),
    fresh: bool = option("Discard earlier measurements."),
    everything: bool = option("Print all configurations, not only the best.", "--all"),
    quiet: bool = option("Print the recommendation only.", "--quiet", "-q"),
) -> None:
    """Measure speed against accuracy for a scene of FILE; recommend a method.

    Runs the scene with methods, tolerances and steps, and compares with a reference on which two
    methods agree, also between the rows. Recommends the cheapest configuration that meets
    `require` and `deadline` of the scene, which `solver auto` then uses, or the goal given here.
    Re-running resumes where the command was interrupted.
    """
    started = time.monotonic()
    model = scene.model(quiet)
    compiled = time.monotonic() - started
    found, _ = attempt(
        lambda: measure_trade(
            model,
            solvers=[name.strip() for name in (solvers or "").split(",") if name.strip()] or None,
            rtols=rtols or RTOLS,
            steps=steps,
            keeps=keeps or KEEPS,
            variants=variants,
            within=dict(within),
            deadline=deadline,
            faster_than=faster_than or 0.0,
            duration=duration,
            budget=max(budget - compiled, _LEAST_SHARE * budget),
            fresh=fresh,
            progress=not quiet,
        ),
        MEASUREMENTS_KEPT,
    )
    save(found, out, plot, html)
    if not quiet:
        print_tables(tables(found, everything))
        print_written(out, html, plot)
        print_text("\n")
    for warning in found.warnings:
        print_text(f"warning: {warning}", err=True)
    print_sentence(found.sentence)
    if found.recommended is not None:  # on a line of its own, to be copied into the scene
        print_text(f"\n  {found.recommended.statement(found.target.settle)}")
