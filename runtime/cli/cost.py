"""Measure 1: show what a scene costs, what was left out, what variants cost."""

import json as json_format
from dataclasses import asdict
from typing import Any

from bgc.emission.operation_cost import Cost
from bgc.printing.text_tables import Table
from bgc.runtime.cli.command import command, option
from bgc.runtime.cli.options import Json, SceneOptions
from bgc.runtime.cli.printing import print_diagnostics, print_tables, print_text
from bgc.runtime.measuring.scene_cost import CostReport, Measured, cost_report
from bgc.slicing.slicing_report import dropped_lines, folded_lines

_SIZES = {
    "states": "states",
    "parameters": "parameters",
    "operations of f": "rhs",
    "operations of J": "jacobian",
    "operations of LU": "factorisation",
}


@command()
def cost(
    scene: SceneOptions,
    *,
    variants: int = option(
        "Largest number of variants to try.",
        within=(0, None),
        default=60,
        show_default=True,
        metavar="N",
    ),
    json: Json,
    quiet: bool = option("Show no progress bar.", "--quiet", "-q"),
) -> None:
    """Show the cost of a scene of FILE, what was left out, and the cost of variants.

    A variant fills one slot with another type that fits. Each is compiled and run for a moment.
    """
    report = cost_report(scene.file, scene.options(), variants, progress=not quiet)
    print_diagnostics(report.warnings)
    if json:
        print_text(json_format.dumps(_as_json(report), indent=2))
    else:
        print_tables(_tables(report))


def _tables(report: CostReport) -> list[Table]:
    title = f"{report.scene} of {report.model}" if report.scene else report.model
    sizes = tuple(
        (name, f"{getattr(report.whole, field):,}", f"{getattr(report.cost, field):,}")
        for name, field in _SIZES.items()
    )
    left_out = tuple((line,) for line in dropped_lines(report.dropped, report.states))
    folded = tuple((line,) for line in folded_lines(report.folded))
    return [
        Table(title, ("", "written", "compiled"), sizes, _speed(report)),
        Table("left out", (), left_out),
        Table("folded: set by the scene, or off", (), folded),
        _variants(report),
    ]


def _speed(report: CostReport) -> str:
    measured = report.measured
    speed = f"not measured: {report.unmeasured}" if measured is None else (
        f"measured: {_time(measured)} a step of {measured.solver}, "
        f"{measured.real_time_factor:,.3g} x real time"
    )  # fmt: skip
    return (
        f"LU by {report.cost.factors}\n"
        f"stiffness: {_rate(report.stiffness)} (largest eigenvalue of J at the start)\n{speed}"
    )


def _variants(report: CostReport) -> Table:
    def row(
        slot: str, kind: str, cost: Cost, stiffness: float | None, run: Measured | None
    ) -> tuple[str, ...]:
        numbers = (cost.states, cost.rhs, cost.jacobian, cost.factorisation)
        counts = (f"{number:,}" for number in numbers)
        return (slot, kind, *counts, _rate(stiffness), _time(run))

    fitting = [
        row(v.variant.name, v.variant.value, v.cost, v.stiffness, v.measured)
        for v in report.variants
        if v.cost
    ]
    rows = (
        (row("as it is", "", report.cost, report.stiffness, report.measured), *fitting)
        if fitting
        else ()
    )
    notes = [
        *(
            ["a step: the fastest of short runs in turns; `-` where it does not run"]
            if fitting and report.measured
            else []
        ),
        *(
            f"{v.variant.name} = {v.variant.value} does not fit as it is: {v.refused}"
            for v in report.variants
            if v.cost is None
        ),
        *([f"{report.skipped} more were not tried: raise --variants"] if report.skipped else []),
    ]
    header = ("slot", "type", "states", "f", "J", "LU", "stiffness", "a step")
    title, spare = "variants, one slot changed at a time", ("LU", "J", "f", "stiffness")
    return Table(title, header, rows, "\n".join(notes), spare)


def _rate(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g} 1/s"


def _time(run: Measured | None) -> str:
    return "-" if run is None else f"{run.step_seconds * 1e6:.3g} us"


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
                "step_seconds": v.measured and v.measured.step_seconds,
                "refused": v.refused,
            }
            for v in report.variants
        ],
        "skipped": report.skipped,
    }
