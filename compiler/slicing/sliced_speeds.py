"""The equations of merged flows after slicing: without the flows that stand still."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from bgc.algebra.dag import Dag, Kind, Level
from bgc.algebra.fingerprint import Fingerprints
from bgc.ir.graph import Node
from bgc.ir.program import Program, SpeedEquations


def sliced_speeds(
    program: Program, values: Mapping[int, Node], number: Mapping[int, int]
) -> SpeedEquations | None:
    """Substitute states that never change, and renumber the others.

    `values` maps the former to nodes of the program, `number` the latter to their new numbers.
    Flows that no longer vary are substituted too, and their equations left out. None where the
    equations need a state that was removed because nothing reads it.
    """
    speeds = program.speeds
    if speeds is None:
        return None
    dag = speeds.dag.copy()
    settled = zip(values, dag.adopted(program.dag, values.values()), strict=True)
    replacement = {dag.symbol(Kind.STATE, old): node for old, node in settled}
    replacement |= {
        dag.symbol(Kind.STATE, old): dag.symbol(Kind.STATE, new) for old, new in number.items()
    }
    roots = (*speeds.values, *speeds.residuals)
    if not dag.symbols_in(roots, Kind.STATE).keys() <= replacement.keys():
        return None
    new = dag.substitute(roots, replacement)
    count = len(speeds.values)
    return _moving(dag, new[:count], new[count:])


def _moving(dag: Dag, values: Sequence[Node], residuals: Sequence[Node]) -> SpeedEquations | None:
    """The equations of the flows that vary, with their symbols renumbered."""
    fingerprints = Fingerprints(dag)
    simple = [fingerprints.simplified(node) for node in values]
    kept = [k for k, node in enumerate(simple) if dag.level[node] > Level.PARAM]
    replacement = {dag.symbol(Kind.SPEED, k): node for k, node in enumerate(simple)}
    replacement |= {
        dag.symbol(Kind.SPEED, old): dag.symbol(Kind.SPEED, new) for new, old in enumerate(kept)
    }
    left = dag.substitute([residuals[k] for k in kept], replacement)
    if not left:
        return None
    return SpeedEquations(dag, tuple(simple[k] for k in kept), tuple(left))
