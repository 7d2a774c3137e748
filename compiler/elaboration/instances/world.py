"""What the parts of elaboration share while they work: the DAG, the report, and each other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from bgc.algebra.dag import Dag
from bgc.diagnostics.report import Report
from bgc.elaboration.instances.demands import Demands
from bgc.elaboration.instances.protocols import Builds, Evaluates, ReadsBonds
from bgc.elaboration.instances.scopes import Names
from bgc.elaboration.instances.tree import Environment, Given
from bgc.grammar import syntax
from bgc.resolution.modules import Package
from bgc.values.expressions import evaluate, evaluate_condition, evaluate_whole
from bgc.values.scope import Namespace
from bgc.values.value import Value


@dataclass(frozen=True, slots=True)
class Edits:
    """What a scene and the command line change, by the path of what they change.

    `sets` replace defaults, `parts` single components, `uses` fill slots, `drives` give
    inputs. Whatever is not `used` in the end names nothing.
    """

    sets: dict[str, Given] = field(default_factory=dict)
    parts: dict[str, dict[tuple[int, ...], Given]] = field(default_factory=dict)
    uses: dict[str, Given] = field(default_factory=dict)
    drives: dict[str, Given] = field(default_factory=dict)
    used: set[tuple[str, str]] = field(default_factory=set)

    def take(self, kind: str, path: str) -> Given | None:
        """The edit of that kind for a path, marked as used."""
        table: dict[str, Given] = getattr(self, kind)
        given = table.get(path)
        if given is not None:
            self.used.add((kind, path))
        return given

    def take_parts(self, path: str) -> Mapping[tuple[int, ...], Given]:
        """The single components that are set of a value, marked as used."""
        parts = self.parts.get(path)
        if parts is None:
            return {}
        self.used.add(("parts", path))
        return parts


@dataclass(slots=True, eq=False)
class World:
    """The shared state of one elaboration."""

    package: Package
    dag: Dag
    report: Report
    edits: Edits
    demands: Demands = field(default_factory=Demands)
    provisional: bool = False  # widths are still being inferred: values show shapes only
    builder: Builds = field(init=False)
    quantities: Evaluates = field(init=False)
    bonds: ReadsBonds = field(init=False)

    def connect(self, builder: Builds, quantities: Evaluates, bonds: ReadsBonds) -> None:
        """Give the world its services; each of them knows the world, so this comes last."""
        self.builder, self.quantities, self.bonds = builder, quantities, bonds

    def evaluate(
        self,
        expr: syntax.Expr,
        env: Environment,
        extra: Mapping[str, Value | Namespace] | None = None,
        rates: bool = False,
    ) -> Value:
        """The value of an expression in its environment, `extra` names first."""
        return evaluate(expr, Names(self, env, extra or {}, rates), self.dag)

    def whole(self, expr: syntax.Expr, env: Environment, what: str, low: int, high: int) -> int:
        """The value of an expression that must be a whole number known at compile time."""
        return evaluate_whole(expr, Names(self, env, {}, False), self.dag, what, low, high)

    def holds(self, condition: syntax.Expr, env: Environment) -> bool:
        """Whether the condition of an `if` with braces holds."""
        scope = Names(self, env, {}, False)
        return evaluate_condition(condition, scope, self.dag, "the condition")
