"""Views of a model: its bond graph, its causality, its equations, to print or to see in a cell."""

from __future__ import annotations

from pathlib import Path

from bgc.diagnostics.catalogue.machine import unknown_file_kind
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.public import public_class
from bgc.driver import Stages
from bgc.printing.causality_table import causality_tables
from bgc.printing.draw import View, lay_out, to_dot
from bgc.printing.latex import latex_equations
from bgc.printing.stages import show_equations, symbol_names
from bgc.printing.text_tables import Table, as_text
from bgc.record_class import dataclass
from bgc.runtime.results.files import written_whole
from bgc.runtime.results.html import tables_html

_KINDS = (".svg", ".dot", ".pdf", ".png")


@public_class
@dataclass(frozen=True, repr=False)
class Drawing:
    """A bond graph with half arrows and causal strokes; a notebook shows it as SVG.

    Attributes
    ----------
    dot
        The graph in the language of Graphviz.
    """

    dot: str

    @property
    def svg(self) -> str:
        """The graph as SVG; BgError (BG056) without Graphviz."""
        return lay_out(self.dot, "svg").decode("utf-8")

    def save(self, path: str | Path) -> None:
        """Write `.svg`, `.pdf`, `.png` or `.dot`; all but the last need Graphviz."""
        target = Path(path)
        kind = target.suffix.lower()
        if kind not in _KINDS:
            raise BgError([unknown_file_kind(str(path), _KINDS)])
        picture = self.dot.encode() if kind == ".dot" else lay_out(self.dot, kind[1:])
        with written_whole(target) as aside:
            aside.write_bytes(picture)

    def __repr__(self) -> str:
        return f"<bgc bond graph: {self.dot.count(chr(10))} lines of dot; `save` writes it>"

    def _repr_svg_(self) -> str | None:
        try:
            return self.svg
        except BgError:
            return None  # without Graphviz: the plain form


@dataclass(frozen=True, repr=False)
class Tables:
    """Tables that print as text and show as tables in a notebook; `tables[0].rows` are texts."""

    tables: tuple[Table, ...]

    def __getitem__(self, number: int) -> Table:
        return self.tables[number]

    def __len__(self) -> int:
        return len(self.tables)

    def __repr__(self) -> str:
        return as_text(self.tables).rstrip()

    def _repr_html_(self) -> str:
        return tables_html(self.tables)


@dataclass(frozen=True, repr=False)
class Equations:
    """The state equations: as text, and in LaTeX, which a notebook typesets.

    Attributes
    ----------
    text
        Initial values, equations and observed quantities, as `bgc equations` prints them.
    latex
        The same as `align*` environments.
    """

    text: str
    latex: str

    def __repr__(self) -> str:
        return self.text.rstrip()

    def _repr_latex_(self) -> str | None:
        if len(self.latex) >= 20_000:  # MathJax would take seconds
            return None
        # Outside of formulas a notebook shows text as it is, comments too.
        return "\n".join(line.removeprefix("% ") for line in self.latex.splitlines())


def drawing_of(stages: Stages, depth: int | None, collapsed: tuple[str, ...]) -> Drawing:
    """Draw the bond graph of a scene compiled up to its causality."""
    return Drawing(to_dot(stages.causal, View(depth, collapsed)))


def causality_of(stages: Stages) -> Tables:
    """Tabulate strokes, storage and loops of a scene compiled up to its equations."""
    return Tables(causality_tables(stages))


def equations_of(stages: Stages) -> Equations:
    """Print the equations of a scene compiled up to `optimise`."""
    program = stages.optimised
    return Equations(show_equations(program), latex_equations(program, symbol_names(program)))
