"""A reduction as one page of HTML that needs nothing else: no file beside it and no network."""

from __future__ import annotations

import io
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import matplotlib

from bgc.runtime.documents.templates import render_template
from bgc.runtime.reduce.reduction import ReductionResult
from bgc.runtime.reduce.reduction_plot import plot_reduction
from bgc.runtime.reduce.reduction_tables import tables
from bgc.runtime.results.files import written_whole


def write_page(found: ReductionResult, path: str | Path) -> None:
    """Write the page: the result, error against operations, all tables, and the scene."""
    with written_whole(path) as aside:
        aside.write_text(page(found), encoding="utf-8")


def page(found: ReductionResult) -> str:
    """Return the page as text."""
    file = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": "bgc", "svg.fonttype": "none"}):
        plot_reduction(found).savefig(file, format="svg", metadata={"Date": None})
    svg = file.getvalue()
    shown = [
        replace(table, title=table.title[:1].upper() + table.title[1:])
        for table in tables(found)
        if table.rows or table.note
    ]
    return render_template(
        "reduction.html.j2",
        title=f"{found.scene} of {found.model}: what its requirements need",
        answer=found.sentence,
        warnings=found.warnings,
        picture=svg[svg.index("<svg") :],
        tables=[replace(shown[0], title="Everything tried"), *shown[1:]],
        text=found.text,
        made=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    )
