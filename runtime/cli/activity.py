"""Measure 4: show where the energy goes, and what could be left out."""

from bgc.runtime.activity.activity import activity_report
from bgc.runtime.activity.activity_tables import as_json, tables
from bgc.runtime.cli.command import command, option
from bgc.runtime.cli.options import Budget, Duration, Json, SceneOptions
from bgc.runtime.cli.printing import print_tables, print_text


@command()
def activity(
    scene: SceneOptions,
    duration: Duration,
    *,
    negligible: float = option(
        "Share of the activity up to which to try leaving a part out.",
        within=(0, 1),
        default=0.01,
        show_default=True,
    ),
    within: float = option(
        "Largest error of a change, as a part of the range; unless the scene has `require`.",
        default=0.01,
        show_default=True,
    ),
    budget: Budget,
    elements: bool = option("List elements instead of parts."),
    json: Json,
    quiet: bool = option("Show no progress bar.", "--quiet", "-q"),
) -> None:
    """Show where the energy of a scene of FILE goes, and what could be left out.

    Ranks parts by the integral of the absolute power. Makes parts with little activity rigid or
    simpler or switches them off, one by one and together, runs each change, and compares it with
    the scene. Prints the lines to add to the scene, with the error of each.
    """
    report = activity_report(
        scene.model(quiet),
        duration=duration,
        negligible=negligible,
        within=within,
        budget=budget,
        progress=not quiet,
    )
    if json:
        print_text(as_json(report))
    else:
        print_tables(tables(report, elements))
