"""A small scene to trade on, and trades of few configurations."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from model_files import model_text

import bgc

OSCILLATOR = model_text("trades_oscillator")


def written(folder: Path, text: str = OSCILLATOR) -> Path:
    path = folder / "scene.bg"
    path.write_text(text)
    return path


def quick(path: Path, **options: Any) -> bgc.Trade:
    """A trade of few configurations."""
    given = {"solvers": ["rodas5p", "rk4"], "rtols": [1e-4, 1e-7], "steps": [0.1, 0.01]}
    return bgc.trade(path, **{**given, "keeps": [1], **options})


def codes(result: bgc.Result) -> list[str]:
    """The warnings of a run."""
    return [warning.code for warning in result.warnings]


def legend_of(figure: Any) -> list[str]:
    """The entries of the legend of a plot that stand for lines of measurements."""
    (axes,) = figure.axes
    return [
        text.get_text()
        for handle, text in zip(
            axes.get_legend().legend_handles, axes.get_legend().get_texts(), strict=True
        )
        if handle.get_marker() not in ("None", "", None)
    ]
