"""A trade as one page of HTML that needs nothing else: no file beside it and no network.

The page is the template `trade.html.j2`; here are its values.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import matplotlib

from bgc.language.column_names import name_in_si
from bgc.runtime.documents.templates import render_template
from bgc.runtime.measuring.judging import combined
from bgc.runtime.results.files import written_whole
from bgc.runtime.trade.measurement import Measurement
from bgc.runtime.trade.trade_result import TradeResult
from bgc.runtime.trade.trade_tables import (
    VARIANT_HEADER,
    VARIANT_NOTE,
    VARIANTS,
    Column,
    columns,
    legend,
    ordered,
    reference_lines,
    unfinished,
    variant_rows,
)
from bgc.runtime.trade.work_precision import plot_trade

_NAMES = ("", "method", "setting", "variant")  # columns of configurations that are text
_VARIANT_NAMES = ("", "in", "cheapest that will do", "lines")


def write_page(trade: TradeResult, path: str | Path) -> None:
    """Write the page."""
    with written_whole(path) as aside:
        aside.write_text(page(trade), encoding="utf-8")


def page(trade: TradeResult) -> str:
    """Return the page as text."""
    rows, every = ordered(trade), columns(trade)
    levels = ", ".join(
        f"rtol {rtol:g}: {combined(agreement, trade.quantities):.1e}"
        for rtol, agreement in trade.reference.levels
    )
    waiting = [row for row in rows if not row.done]
    return render_template(
        "trade.html.j2",
        title=f"{trade.scene} of {trade.model}: speed against accuracy",
        answer=trade.sentence,
        warnings=trade.warnings,
        picture=_svg(trade),
        configurations={
            "header": [column.heading for column in every],
            "names": sum(column.heading in _NAMES for column in every),
            "rows": [_row(trade, every, row) for row in rows if row.done],
        },
        legend=legend(trade),
        variants={
            "title": VARIANTS.capitalize(),
            "note": VARIANT_NOTE.capitalize(),
            "header": VARIANT_HEADER,
            "names": _VARIANT_NAMES,
            "rows": variant_rows(trade),
        },
        errors=_errors(trade),
        unfinished=unfinished(waiting),
        unfinished_count=len(waiting),
        facts=[line for (line,) in reference_lines(trade)],
        levels=levels,
        made=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    )


def _svg(trade: TradeResult) -> str:
    if not any(row.done for row in trade.measurements):
        return ""
    file = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": "bgc", "svg.fonttype": "none"}):
        plot_trade(trade).savefig(file, format="svg", metadata={"Date": None})
    text = file.getvalue()
    return text[text.index("<svg") :]


def _row(trade: TradeResult, every: Sequence[Column], row: Measurement) -> dict[str, Any]:
    """A row of the configurations; `worth` is the number by which a cell with a unit is sorted."""
    marks = {
        "best": row.configuration == trade.recommended,
        "front": row.configuration in trade.verdict.front,
    }
    found = [
        {"text": c.text(row), "worth": None if c.worth is None else f"{c.worth(row):.9g}"}
        for c in every
    ]
    return {"kind": " ".join(name for name, holds in marks.items() if holds), "cells": found}


def _errors(trade: TradeResult) -> dict[str, Any]:
    """The errors of each quantity, in its unit, of the configurations on the front."""
    scale = "required, else range" if trade.target.required else "range"
    front = (row for row in ordered(trade) if row.configuration in trade.verdict.front)
    return {
        "header": [q.shown.heading(name_in_si(q.name)) for q in trade.quantities],
        "rows": [
            (scale, [f"{q.shown.number(q.scale):.3g}" for q in trade.quantities]),
            *(
                (
                    row.configuration.label,
                    [
                        f"{q.shown.number(error):.2g}"
                        for q, error in zip(trade.quantities, row.errors, strict=True)
                    ],
                )
                for row in front
            ),
        ],
    }
