"""The shared state of an elaboration: the DAG, the report, the scene's edits, the services."""

from __future__ import annotations

from collections.abc import Mapping

from bgc.algebra.dag import Dag
from bgc.diagnostics.collection import Report
from bgc.diagnostics.source import Span
from bgc.elaboration.instances.demands import Demands
from bgc.elaboration.instances.protocols import Builds, Evaluates, ReadsBonds
from bgc.elaboration.instances.scopes import Names
from bgc.elaboration.instances.tree import Environment, Given
from bgc.grammar import syntax
from bgc.record_class import dataclass, field
from bgc.resolution.modules import Package
from bgc.values.data_expressions import Table
from bgc.values.expressions import evaluate, evaluate_condition, evaluate_whole, resolve_path
from bgc.values.scope import Namespace
from bgc.values.value import Value


@dataclass(frozen=True, slots=True)
class Edits:
    """Changes that a scene and the command line make to a model, keyed by path.

    `sets` replace defaults, `parts` replace single components, `uses` fill slots, `drives` define
    inputs. `used` holds the (kind, path) pairs that elaboration has applied; an edit that is not
    among them at the end has no target in the model.
    """

    sets: dict[str, Given] = field(default_factory=dict)
    parts: dict[str, dict[tuple[int, ...], Given]] = field(default_factory=dict)
    uses: dict[str, Given] = field(default_factory=dict)
    drives: dict[str, Given] = field(default_factory=dict)
    used: set[tuple[str, str]] = field(default_factory=set)

    def take(self, kind: str, path: str) -> Given | None:
        """Return the edit of a kind for a path, and mark it as used."""
        table: dict[str, Given] = getattr(self, kind)
        given = table.get(path)
        if given is not None:
            self.used.add((kind, path))
        return given

    def take_parts(self, path: str) -> Mapping[tuple[int, ...], Given]:
        """Return the component edits of a value, and mark them as used."""
        parts = self.parts.get(path)
        if parts is None:
            return {}
        self.used.add(("parts", path))
        return parts


@dataclass(slots=True, eq=False, repr=False)
class World:
    """The shared state of one elaboration."""

    package: Package
    dag: Dag
    report: Report
    edits: Edits
    demands: Demands = field(default_factory=Demands)
    provisional: bool = False  # widths are being inferred: bond variables are placeholders
    builder: Builds = field(init=False)
    quantities: Evaluates = field(init=False)
    bonds: ReadsBonds = field(init=False)

    def connect(self, builder: Builds, quantities: Evaluates, bonds: ReadsBonds) -> None:
        """Set the services, which are constructed with this world."""
        self.builder, self.quantities, self.bonds = builder, quantities, bonds

    def evaluate(
        self,
        expr: syntax.Expr,
        env: Environment,
        extra: Mapping[str, Value | Namespace] | None = None,
        rates: bool = False,
    ) -> Value:
        """Evaluate an expression in its environment; `extra` names take precedence.

        `rates` permits `der(x)`.
        """
        return evaluate(expr, Names(self, env, extra or {}, rates), self.dag)

    def resolve(self, expr: syntax.Expr, env: Environment) -> Value | Namespace:
        """Evaluate an expression that may name a data file or its numbers, as they are."""
        return resolve_path(expr, Names(self, env, {}, False), self.dag)

    def data(self, name: str, span: Span) -> Namespace:
        """The contents of a data file."""
        file = self.package.data_file(name, span)
        return Table(file.shown, "", file.entries)

    def whole(self, expr: syntax.Expr, env: Environment, what: str, low: int, high: int) -> int:
        """Evaluate an expression that must be a compile-time integer from `low` to `high`."""
        return evaluate_whole(expr, Names(self, env, {}, False), self.dag, what, low, high)

    def holds(self, condition: syntax.Expr, env: Environment) -> bool:
        """Return whether the condition of a compile-time `if` holds."""
        scope = Names(self, env, {}, False)
        return evaluate_condition(condition, scope, self.dag, "the condition")
