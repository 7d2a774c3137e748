"""`bgc trade`."""

from __future__ import annotations

import time
from pathlib import Path

import click

from bgc.runtime.cli.app import INTERRUPTED, print_diagnostics
from bgc.runtime.cli.options import (
    check_target,
    model_file,
    read_assignments,
    read_uses,
    scene_option,
    set_option,
    use_option,
)
from bgc.runtime.cli.printing import print_sentence, print_tables, print_written
from bgc.runtime.compiling import compile_model
from bgc.runtime.running.quantity import read_quantity
from bgc.runtime.trade.configurations import KEEPS, RTOLS
from bgc.runtime.trade.tables import tables
from bgc.runtime.trade.trade import trade as measure_trade

_LEAST_SHARE = 0.5  # of the budget, which compiling does not take
_PICTURES = (".png", ".svg", ".pdf")


@click.command()
@model_file
@scene_option
@set_option
@use_option
@click.option("--out", metavar="FILE", help="Write all measurements: .csv.")
@click.option(
    "--plot", metavar="FILE", help="Draw error against processor time: .png, .svg or .pdf."
)
@click.option("--html", metavar="FILE", help="Write a page with table and plot: .html.")
@click.option(
    "--solvers", metavar="NAMES", help="Methods to try: rodas5p,ros34prw; by default all."
)
@click.option("--rtols", metavar="NUMBERS", help="Tolerances of adaptive methods: 1e-3,1e-6.")
@click.option("--steps", metavar="TIMES", help='Steps of fixed-step methods: "1 ms, 0.5 ms".')
@click.option(
    "--keep",
    "keeps",
    metavar="NUMBERS",
    help="Numbers of steps for which a Jacobian is kept: 1,2,5.",
)
@click.option(
    "--variants",
    multiple=True,
    metavar="VARIANT",
    help='Variants to measure too: a slot to fill with other types ("*.lock": several slots '
    'together; "all": each slot by itself), "activity" (without the parts that bgc activity finds '
    'negligible), or lines of a scene: "use a = B; set c = 0".',
)
@click.option(
    "--time", "duration", metavar="TIME", help="Simulated time; by default that of the scene."
)
@click.option(
    "--budget",
    metavar="TIME",
    default="300 s",
    show_default=True,
    help="Longest time for the measurements.",
)
@click.option("--fresh", is_flag=True, help="Discard earlier measurements.")
@click.option(
    "--all",
    "everything",
    is_flag=True,
    help="Print all configurations, not only the best.",
)
@click.option("--quiet", "-q", is_flag=True, help="Print the recommendation only.")
@click.pass_context
def trade(
    context: click.Context,
    file: Path,
    scene: str | None,
    assignments: tuple[str, ...],
    uses: tuple[str, ...],
    out: str | None,
    plot: str | None,
    html: str | None,
    solvers: str | None,
    rtols: str | None,
    steps: str | None,
    keeps: str | None,
    variants: tuple[str, ...],
    duration: str | None,
    budget: str,
    fresh: bool,
    everything: bool,
    quiet: bool,
) -> None:
    """Measure speed against accuracy for a scene of FILE; recommend a method.

    Runs the scene with methods, tolerances and steps, and compares with a reference on which two
    methods agree. Recommends the cheapest configuration that meets `require` and `deadline` of
    the scene; `solver auto` in the scene then uses it. Re-running resumes where the command was
    interrupted.
    """
    check_target(out, (".csv",))
    check_target(plot, _PICTURES)
    check_target(html, (".html",))
    started, seconds = time.monotonic(), read_quantity(budget, "--budget", "s")
    chosen = compile_model(
        file, scene, dict(read_assignments(assignments)), uses=dict(read_uses(uses))
    )
    print_diagnostics(chosen.warnings)
    try:
        found = measure_trade(
            chosen,
            solvers=_split(solvers) or None,
            rtols=_numbers(rtols, "--rtols") or RTOLS,
            steps=[read_quantity(text, "--steps", "s") for text in _split(steps)] or None,
            keeps=_numbers(keeps, "--keep") or KEEPS,
            variants=variants,
            duration=None if duration is None else read_quantity(duration, "--time", "s"),
            budget=max(seconds - (time.monotonic() - started), _LEAST_SHARE * seconds),
            fresh=fresh,
            progress=not quiet,
        )
    except KeyboardInterrupt:
        click.echo("interrupted; measurements are kept: the same command continues", err=True)
        context.exit(INTERRUPTED)
    if out is not None:
        found.to_csv(out)
    if html is not None:
        found.to_html(html)
    if plot is not None:
        found.plot(plot)
    if not quiet:
        print_tables(tables(found, everything))
        print_written(out, html, plot)
        click.echo()
    for warning in found.warnings:
        click.echo(f"warning: {warning}", err=True)
    print_sentence(found.sentence)
    if found.recommended is not None:  # on a line of its own, to be copied into the scene
        click.echo(f"\n  {found.recommended.statement(found.target.settle)}")


def _split(text: str | None) -> list[str]:
    return [part.strip() for part in (text or "").split(",") if part.strip()]


def _numbers(text: str | None, option: str) -> list[float]:
    return [read_quantity(part, option, "") for part in _split(text)]
