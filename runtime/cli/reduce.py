"""Measure 5: leave out of a scene what it does not require, and prove it."""

from pathlib import Path

from bgc.runtime.cli.command import Target, command, option
from bgc.runtime.cli.options import (
    PICTURE,
    SECONDS,
    TABLE,
    Deadline,
    Duration,
    Json,
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
)
from bgc.runtime.reduce.reduce import reduce as reduce_scene
from bgc.runtime.reduce.reduction_tables import as_json, tables


@command()
def reduce(
    scene: SceneOptions,
    *,
    within: Within,
    over: tuple[str, ...] = option(
        'Hold the requirement for all of these values of a parameter: "seed=1, 2, 3". May be '
        "repeated.",
        metavar="VALUES",
    ),
    deadline: Deadline,
    duration: Duration,
    budget: float = option(
        "Longest time for the study.", type=SECONDS, default="600 s", show_default=True
    ),
    fresh: bool = option("Discard earlier trials."),
    out: str | None = option("Write the reduced scene: .bg.", "--out", "-o", type=Target(".bg")),
    table: str | None = option("Write all that was tried: .csv.", type=TABLE),
    plot: str | None = option(
        "Draw error against operations of all that was tried: .png, .svg or .pdf.", type=PICTURE
    ),
    html: str | None = option("Write a page with plot and tables: .html.", type=Target(".html")),
    json: Json,
    quiet: bool = option("Print the result only.", "--quiet", "-q"),
) -> None:
    """Find the coarsest form of a scene of FILE that meets its requirements.

    Gives parts smaller dimensions and other models in their slots, then chooses a method, and
    compares each run with the whole scene. Prints a scene that extends the original, with the
    proof. Re-running resumes where Ctrl-C or the budget ended it.
    """
    model = scene.model(quiet)
    found, _ = attempt(
        lambda: reduce_scene(
            model,
            within=dict(within),
            over=over,
            deadline=deadline,
            duration=duration,
            budget=budget,
            fresh=fresh,
            progress=not quiet,
        ),
        MEASUREMENTS_KEPT,
    )
    written = out if found.reduced is not None else None
    if written is not None:
        found.to_bg(Path(written))
    if table is not None:
        found.to_csv(table)
    if plot is not None:
        found.plot(plot)
    if html is not None:
        found.to_html(html)
    if json:
        print_text(as_json(found))
        return
    if not quiet:
        print_tables(tables(found))
        print_written(written, table, plot, html)
        print_text("\n")
    for warning in found.warnings:
        print_text(f"warning: {warning}", err=True)
    print_sentence(found.sentence)
    if written is None and found.reduced is not None:  # to be copied into the file
        print_text(f"\n{found.text}")
