"""`bgc cost`."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from bgc.emission.cost import Cost
from bgc.options import Options
from bgc.printing.tables import Table
from bgc.runtime.cli.app import print_diagnostics
from bgc.runtime.cli.options import (
    model_file,
    read_assignments,
    read_uses,
    scene_option,
    set_option,
    use_option,
)
from bgc.runtime.cli.printing import print_tables
from bgc.runtime.measuring.cost import CostReport, VariantCost, cost_report
from bgc.slicing.report import dropped_lines, folded_lines

_MOST_VARIANTS = 60


@click.command()
@model_file
@scene_option
@set_option
@use_option
@click.option(
    "--variants",
    "most",
    type=click.IntRange(min=0),
    default=_MOST_VARIANTS,
    show_default=True,
    metavar="N",
    help="Largest number of variants to try.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON, in SI units with all digits.")
@click.option("--quiet", "-q", is_flag=True, help="Show no progress bar.")
def cost(
    file: Path,
    scene: str | None,
    assignments: tuple[str, ...],
    uses: tuple[str, ...],
    most: int,
    as_json: bool,
    quiet: bool,
) -> None:
    """Show the cost of a scene of FILE, what was left out, and the cost of variants.

    A variant fills one slot with another type that fits.
    """
    options = Options(scene, read_assignments(assignments), uses=read_uses(uses))
    report = cost_report(file, options, most, progress=not quiet)
    print_diagnostics(report.warnings)
    if as_json:
        click.echo(json.dumps(_as_json(report), indent=2))
    else:
        print_tables(_tables(report))


# --- tables -----------------------------------------------------------------------------------


def _tables(report: CostReport) -> list[Table]:
    scene = f"{report.scene} of {report.model}" if report.scene else report.model
    return [
        Table(scene, ("", "written", "compiled"), _sizes(report), _speed(report)),
        Table("left out", (), _lines(dropped_lines(report.dropped, report.states))),
        Table("folded: set by the scene, or off", (), _lines(folded_lines(report.folded))),
        _variants(report),
    ]


def _lines(lines: tuple[str, ...]) -> tuple[tuple[str, ...], ...]:
    return tuple((line,) for line in lines)


def _sizes(report: CostReport) -> tuple[tuple[str, ...], ...]:
    whole, ours = report.whole, report.cost
    rows = (
        ("states", whole.states, ours.states),
        ("parameters", whole.parameters, ours.parameters),
        ("operations of f", whole.rhs, ours.rhs),
        ("operations of J", whole.jacobian, ours.jacobian),
        ("operations of LU", whole.factorisation, ours.factorisation),
    )
    return tuple((name, f"{before:,}", f"{after:,}") for name, before, after in rows)


def _speed(report: CostReport) -> str:
    lines = [
        f"LU by {report.cost.factors}",
        f"stiffness: {_rate(report.stiffness)} (largest eigenvalue of J at the start)",
    ]
    if report.measured is not None:
        measured = report.measured
        lines.append(
            f"measured: {_time(measured.step_seconds)} a step of {measured.solver}, "
            f"{measured.real_time_factor:,.3g} x real time"
        )
    else:
        lines.append(f"not measured: {report.unmeasured}")
    return "\n".join(lines)


def _variants(report: CostReport) -> Table:
    header = ("slot", "type", "states", "f", "J", "LU", "stiffness", "a step")
    base = (*_counts(report.cost), _rate(report.stiffness), _time(report.estimate(report.cost)))
    fitting = [v for v in report.variants if v.cost is not None]
    rows = [("as it is", "", *base), *(_row(report, variant) for variant in fitting)]
    notes = [
        f"{v.variant.name} = {v.variant.value} does not fit as it is: {v.refused}"
        for v in report.variants
        if v.cost is None
    ]
    if report.skipped:
        notes.append(f"{report.skipped} more were not tried: raise --variants")
    if fitting and report.measured is not None:
        notes.insert(0, "times of variants are estimates, by operations")
    title = "variants, one slot changed at a time"
    spare = ("LU", "J", "f", "stiffness")
    return Table(title, header, tuple(rows) if fitting else (), "\n".join(notes), spare)


def _row(report: CostReport, variant: VariantCost) -> tuple[str, ...]:
    assert variant.cost is not None
    return (
        variant.variant.name,
        variant.variant.value,
        *_counts(variant.cost),
        _rate(variant.stiffness),
        _time(report.estimate(variant.cost)),
    )


def _counts(cost: Cost) -> tuple[str, ...]:
    numbers = (cost.states, cost.rhs, cost.jacobian, cost.factorisation)
    return tuple(f"{number:,}" for number in numbers)


def _rate(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g} 1/s"


def _time(seconds: float | None) -> str:
    return "-" if seconds is None else f"{seconds * 1e6:.3g} us"


# --- JSON -------------------------------------------------------------------------------------


def _as_json(report: CostReport) -> dict[str, Any]:
    return {
        "scene": report.scene,
        "model": report.model,
        "written": asdict(report.whole),
        "compiled": asdict(report.cost),
        "stiffness": report.stiffness,
        "dropped": [{"state": d.name, "reason": d.reason.value} for d in report.dropped],
        "folded": dict(report.folded),
        "measured": None if report.measured is None else asdict(report.measured),
        "unmeasured": report.unmeasured,
        "variants": [
            {
                "slot": v.variant.name,
                "type": v.variant.value,
                "cost": None if v.cost is None else asdict(v.cost),
                "stiffness": v.stiffness,
                "step_seconds": None if v.cost is None else report.estimate(v.cost),
                "refused": v.refused,
            }
            for v in report.variants
        ],
        "skipped": report.skipped,
    }
