"""A trade as one page of HTML that needs nothing else: no file beside it and no network."""

from __future__ import annotations

import io
from datetime import UTC, datetime
from html import escape
from pathlib import Path

import matplotlib

from bgc.runtime.measuring.errors import combined
from bgc.runtime.results.files import written_whole
from bgc.runtime.trade.measurement import Measurement
from bgc.runtime.trade.plot import plot_trade
from bgc.runtime.trade.result import TradeResult
from bgc.runtime.trade.tables import (
    VARIANT_HEADER,
    VARIANT_NOTE,
    VARIANTS,
    cells,
    header,
    legend,
    ordered,
    reference_lines,
    unfinished,
    variant_rows,
)

_STYLE = """
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 72rem; margin: 0 auto; padding: 1rem; }
h1 { font-size: 1.4rem; margin: .5rem 0; } h2 { font-size: 1.1rem; margin: 1.6rem 0 .4rem; }
.answer { border-left: .3rem solid #0072B2; padding: .5rem .8rem; background: #0072b21a; }
.warning { border-left: .3rem solid #D55E00; padding: .5rem .8rem; background: #d55e001a; }
.wide { overflow-x: auto; } .plot { background: white; border-radius: .3rem; }
.plot svg { width: 100%; height: auto; min-width: 34rem; display: block; }
table { border-collapse: collapse; font-size: .85rem; font-variant-numeric: tabular-nums; }
th, td { padding: .25rem .6rem; text-align: right; white-space: nowrap; }
th { position: sticky; top: 0; background: Canvas; border-bottom: 2px solid; }
table.sort th { cursor: pointer; } th[aria-sort=ascending]::after { content: " \\25B2"; }
th[aria-sort=descending]::after { content: " \\25BC"; }
td { border-bottom: 1px solid #8884; } .name { text-align: left; }
tr.front { font-weight: 600; } tr.best { background: #0072b233; } tr.not { opacity: .6; }
code { font-size: .95em; } li { margin: .1rem 0; } footer, .marks { font-size: .85rem; }
td.reason { white-space: normal; text-align: left; min-width: 16rem; }
"""

_SCRIPT = """
for (const table of document.querySelectorAll("table.sort")) {
  const heads = [...table.tHead.rows[0].cells], body = table.tBodies[0];
  heads.forEach((head, column) => head.addEventListener("click", () => {
    const down = head.getAttribute("aria-sort") === "ascending";
    const key = row => row.cells[column].dataset.value ?? row.cells[column].textContent;
    const rows = [...body.rows].sort((a, b) => {
      const x = key(a), y = key(b), p = parseFloat(x), q = parseFloat(y);
      if (x === "" || y === "") return (x === "") - (y === "");
      const order = isNaN(p) || isNaN(q) ? x.localeCompare(y) : p - q;
      return down ? -order : order;
    });
    heads.forEach(other => other.removeAttribute("aria-sort"));
    head.setAttribute("aria-sort", down ? "descending" : "ascending");
    body.append(...rows);
  }));
}
"""


def write_page(trade: TradeResult, path: str | Path) -> None:
    """Write the page."""
    with written_whole(path) as aside:
        aside.write_text(page(trade), encoding="utf-8")


def page(trade: TradeResult) -> str:
    """The page as text."""
    title = f"{trade.scene} of {trade.model}: speed against accuracy"
    warnings = "".join(f'<p class="warning">{escape(text)}</p>\n' for text in trade.warnings)
    facts = "".join(f"<li>{escape(line)}</li>\n" for (line,) in reference_lines(trade))
    levels = ", ".join(
        f"rtol {rtol:g}: {combined(agreement, trade.quantities):.1e}"
        for rtol, agreement in trade.reference.levels
    )
    made = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)}</title>
<style>{_STYLE}</style>
</head>
<body>
<h1>{escape(title)}</h1>
<p class="answer">{_with_code(trade.sentence)}</p>
{warnings}<div class="wide plot">{_svg(trade)}</div>
<h2>Configurations</h2>
<p>A click on a heading sorts. Bold rows are on the Pareto front: nothing else is both cheaper and
more accurate. Times are processor times, medians of several runs for rows on or near the front; the
worst is what has to be done by a deadline.</p>
<div class="wide">{_configurations(trade)}</div>
<ul class="marks">{"".join(f"<li>{escape(line)}</li>" for line in legend(trade))}</ul>
{_variants(trade)}{_quantities(trade)}{_not_measured(trade)}<h2>What was measured against what</h2>
<ul>
{facts}<li>difference of the two methods at each tolerance tried: {escape(levels)}</li>
</ul>
<footer>{made}, by <code>bgc trade</code></footer>
<script>{_SCRIPT}</script>
</body>
</html>
"""


def _with_code(text: str) -> str:
    """Text in backticks as code."""
    pieces = escape(text).split("`")
    return "".join(f"<code>{p}</code>" if k % 2 else p for k, p in enumerate(pieces))


def _svg(trade: TradeResult) -> str:
    if not any(row.done for row in trade.measurements):
        return ""
    file = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": "bgc", "svg.fonttype": "none"}):
        plot_trade(trade).savefig(file, format="svg", metadata={"Date": None})
    text = file.getvalue()
    return text[text.index("<svg") :]


def _configurations(trade: TradeResult) -> str:
    names = ("", "method", "setting", "variant")
    heads = "".join(
        f"<th{' class=name' if name in names else ''}>{escape(name)}</th>" for name in header(trade)
    )
    rows = "".join(_row(trade, row) for row in ordered(trade) if row.done)
    return f'<table class="sort"><thead><tr>{heads}</tr></thead><tbody>\n{rows}</tbody></table>'


def _row(trade: TradeResult, row: Measurement) -> str:
    best = row.configuration == trade.recommended
    on_front = row.configuration in trade.verdict.front
    kind = " ".join([*(["best"] if best else []), *(["front"] if on_front else [])])
    worth = _sort_keys(trade, row)
    names = 4 if "variant" in header(trade) else 3
    tds = []
    for place, (name, text) in enumerate(zip(header(trade), cells(trade, row), strict=True)):
        value = f' data-value="{worth[name]:.9g}"' if name in worth else ""
        tds.append(f"<td{' class=name' if place < names else ''}{value}>{escape(text)}</td>")
    return f'<tr class="{kind}">{"".join(tds)}</tr>\n'


def _sort_keys(trade: TradeResult, row: Measurement) -> dict[str, float]:
    """What cells with units are sorted by."""
    keys = {
        "error/required": trade.target.error(row),
        "error/range": trade.target.error(row),
        "cpu/s": row.cpu,
        "x real time": row.real_time_factor,
        "a step": row.mean_step,
        "worst step": row.worst,
        "worst sample": row.worst,
    }
    counts = {"steps": "steps", "f": "rhs", "J": "jacobians", "LU": "factorisations"}
    return keys | {head: row.counts.get(name, 0.0) for head, name in counts.items()}


def _variants(trade: TradeResult) -> str:
    """The error that each variant brings, and what it saves."""
    found = variant_rows(trade)
    if not found:
        return ""
    names = ("", "in", "cheapest that will do", "lines")
    kinds = [" class=name" if name in names else "" for name in VARIANT_HEADER]
    heads = "".join(f"<th{k}>{escape(h)}</th>" for k, h in zip(kinds, VARIANT_HEADER, strict=True))
    rows = "".join(
        "<tr>"
        + "".join(f"<td{k}>{escape(cell)}</td>" for k, cell in zip(kinds, row, strict=True))
        + "</tr>\n"
        for row in found
    )
    return (
        f"<h2>{VARIANTS.capitalize()}</h2>\n<p>{escape(VARIANT_NOTE.capitalize())}.</p>\n"
        f'<div class="wide"><table><thead><tr>{heads}</tr></thead><tbody>\n{rows}</tbody>'
        "</table></div>\n"
    )


def _quantities(trade: TradeResult) -> str:
    """The errors of each quantity, in its unit, of the configurations on the front."""
    front = [row for row in ordered(trade) if row.configuration in trade.verdict.front]
    heads = "".join(
        f"<th>{escape(f'{q.name} [{q.unit}]' if q.unit else q.name)}</th>" for q in trade.quantities
    )
    scales = "".join(f"<td>{q.scale:.3g}</td>" for q in trade.quantities)
    rows = "".join(
        f"<tr><td class=name>{escape(row.configuration.label)}</td>"
        + "".join(f"<td>{error:.2g}</td>" for error in row.errors)
        + "</tr>\n"
        for row in front
    )
    scale = "required, else range" if trade.target.required else "range"
    return (
        "<h2>Largest errors on the front</h2>\n"
        f'<div class="wide"><table><thead><tr><th></th>{heads}</tr></thead><tbody>\n'
        f"<tr><td class=name>{scale}</td>{scales}</tr>\n{rows}</tbody></table></div>\n"
    )


def _not_measured(trade: TradeResult) -> str:
    rows = [row for row in ordered(trade) if not row.done]
    if not rows:
        return ""
    lines = "".join(
        f"<tr class=not><td class=name>{escape(name)}</td><td class=name>{status}</td>"
        f"<td class=reason>{escape(settings)}</td><td class=reason>{escape(reason)}</td></tr>\n"
        for name, status, settings, reason in unfinished(rows)
    )
    return (
        "<h2>Not measured</h2>\n<details><summary>Failed, stopped, refused or needless: "
        f"{len(rows)}</summary><div class=wide><table><tbody>\n{lines}</tbody></table></div>"
        "</details>\n"
    )
