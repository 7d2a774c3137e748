"""Read the run of a scene: solver, facts of the run, plots, kept paths, required accuracy."""

from __future__ import annotations

from typing import Any

from bgc.diagnostics.catalogue import did_you_mean, names, scenes
from bgc.diagnostics.catalogue.realtime import unknown_policy
from bgc.diagnostics.catalogue.studies import bad_observable
from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.instances.components import component_names
from bgc.elaboration.instances.scopes import Names, path_of
from bgc.elaboration.instances.world import World
from bgc.elaboration.scenes.edits import canonical_path
from bgc.elaboration.scenes.observations import Observed, is_path
from bgc.elaboration.scenes.scene_choice import Scene, constant_of
from bgc.grammar import syntax
from bgc.grammar.scene_statements import SCENE_STATEMENTS, statement_of
from bgc.ir.scene_nodes import Requirement
from bgc.language.column_names import column_of, name_in_si, vector_of
from bgc.language.records import Option, Where, options_of
from bgc.language.scene import Plot, Rest
from bgc.language.scene import Scene as Record
from bgc.language.solver import SOLVER_OPTIONS, Solver
from bgc.values.expressions import resolve_path
from bgc.values.units import Dimension, shown_of, si_text

_NUMBER: Dimension = (0, 0, 0, 0, 0, 0, 0)


def read_requirements(world: World, scene: Scene, observed: Observed) -> tuple[Requirement, ...]:
    """Read the required accuracies, one per component of an expression or observed column."""
    found: list[Requirement] = []
    columns = {o.node: o.name for o in reversed(observed.observations)}
    for item in scene.statements(syntax.Require):
        if item.tolerance is None:
            continue
        with world.report.collecting():
            expr = _expand_column(scene, item.value)
            value = world.evaluate(expr, scene.env)
            tolerance = constant_of(world, scene, item.tolerance, "the tolerance", value.unit)
            if not tolerance > 0:
                raise BgError(
                    [scenes.not_positive(item.tolerance.span, "the tolerance", tolerance)]
                )
            labels = component_names(path_of(item.value), value.shape)
            for label, unit, node in zip(labels, value.units, value.nodes, strict=True):
                own = f"{label} (required)" if label in observed.columns else label
                name = columns.setdefault(node, own)
                found.append(
                    Requirement(name, si_text(unit), node, tolerance, item.span, shown_of(unit))
                )
    return tuple(found)


_TURNED = {"<": ">", "<=": ">=", ">": "<", ">=": "<="}


def read_criteria(world: World, scene: Scene, observed: Observed) -> tuple[str, ...]:
    """Read the limits of observed columns, `require abs(roll) < 3 deg;`, as texts in SI.

    The texts are those of `bgc operability`, `peak(roll) < 0.05236 rad`.
    """
    known = [name_in_si(column) for column in observed.columns]
    vectors = [vector for column in known if (vector := vector_of(column))]
    found = []
    for item in scene.statements(syntax.Require):
        if item.tolerance is not None:
            continue
        with world.report.collecting():
            function, path, sign, limit = _comparison(item)
            name = path_of(path)
            name = name if name in vectors else column_of(name)
            if name not in (*known, *vectors):
                reason = "the scene does not observe it"
                way_out = did_you_mean(name, [*known, *vectors]) or f"add `observe {name};`"
                raise BgError([bad_observable(name, reason, way_out, path.span)])
            unit = world.evaluate(_expand_column(scene, path), scene.env).unit
            number = constant_of(world, scene, limit, "the limit", unit)
            label = si_text(unit) if unit is not None else "1"
            amount = f"{number!r} {label}" if label != "1" else repr(number)
            usual = "max" if sign.startswith("<") else "min"
            found.append(f"{function or usual}({name}) {sign} {amount}")
    return tuple(found)


def _comparison(item: syntax.Require) -> tuple[str, syntax.Expr, str, syntax.Expr]:
    """Split `abs(roll) < 3 deg` into its function, column, comparison and limit."""
    match item.value:
        case syntax.Binary(operator=sign, left=left, right=right) if sign in _TURNED:
            for column, limit, turned in ((left, right, sign), (right, left, _TURNED[sign])):
                match column:
                    case syntax.Call(function="abs", arguments=(inner,)) if is_path(inner):
                        return "peak", inner, turned, limit
                    case _ if is_path(column):
                        return "", column, turned, limit
        case _:
            pass
    reason = "it neither has a tolerance nor compares an observed column"
    way_out = "write `require value within tolerance;` or `require column < limit;`"
    raise BgError([bad_observable("require", reason, way_out, item.value.span)])


def _expand_column(scene: Scene, expr: syntax.Expr) -> syntax.Expr:
    """Replace the alias of a column by its expression, unless a member has the same name."""
    root = scene.env.instance
    match expr:
        case syntax.Name(name=name) if root is None or name not in root.members:
            own = (item.value for item in scene.statements(syntax.Observe) if item.alias == name)
            return next(own, expr)
        case _:
            return expr


def read_kept(world: World, scene: Scene) -> tuple[str, ...]:
    """Read the paths of all `keep` statements."""
    found = []
    for item in scene.statements(syntax.Keep):
        with world.report.collecting():
            resolve_path(item.target, Names(world, scene.env, {}, False), world.dag)
            found.append(canonical_path(world, item.target, scene.env))
    return tuple(found)


def read_facts(world: World, scene: Scene, observed: Observed, rest: Rest | None) -> Record:
    """Read solver, facts of the run and plots; `rest` is the start at rest."""
    _report_repeated(world, scene)
    solver = next(scene.statements(syntax.Solver), None)
    return Record(
        name=scene.name,
        model=scene.model.syntax.name,
        columns=observed.columns,
        accounts=observed.accounts,
        solver=_solver(world, scene, solver) if solver else Solver(),
        plots=_plots(world, scene, observed),
        rest=rest,
        criteria=read_criteria(world, scene, observed),
        **_values(world, scene),
    )


def _report_repeated(world: World, scene: Scene) -> None:
    """Report a second statement of those that a scene has once."""
    for row in SCENE_STATEMENTS.values():
        found = [item for item in scene.items if statement_of(item) is row]
        if row.key == "" and len(found) > 1:
            world.report.add(scenes.said_twice(found[1].span, row.word, found[0].span))


def _values(world: World, scene: Scene) -> dict[str, Any]:
    """Read what statements such as `step 1 ms;` state, by the field of the record."""
    known = options_of(Record, Where.SCENE)
    first = {item.word: item for item in reversed(list(scene.statements(syntax.Fact)))}
    found: dict[str, Any] = {}
    for item in first.values():
        for name, expr in ((given.name or "", given.value) for given in item.values):
            with world.report.collecting():
                found[name] = _value(world, scene, expr, known[name])
    return found


def _value(world: World, scene: Scene, expr: syntax.Expr, known: Option) -> float | str:
    """Read a chosen word, or a positive number; one without a unit, as `2*pi`, is in SI units."""
    if isinstance(expr, syntax.Text):
        if expr.value not in known.choices:
            raise BgError([unknown_policy(expr.span, expr.value)])
        return expr.value
    is_plain = world.evaluate(expr, scene.env).unit == _NUMBER
    what = f"the {known.noun}"
    number = constant_of(world, scene, expr, what, None if is_plain else known.dimension)
    if not number > 0:
        raise BgError([scenes.not_positive(expr.span, what, number)])
    return number


def _plots(world: World, scene: Scene, observed: Observed) -> tuple[Plot, ...]:
    """The panels of the scene's plot, of columns or of vectors by their common name."""
    columns = observed.columns
    vectors = (vector for column in columns if (vector := vector_of(column)))
    known = {name_in_si(column): column for column in ("time", *columns, *vectors)}

    def column(path: syntax.Expr) -> str:
        name = path_of(path)
        for spelling in (name, column_of(name)):
            if spelling in known:
                return known[spelling]
        if any(
            name == wrong or name.startswith((f"{wrong}.", f"{wrong}["))
            for wrong in observed.refused
        ):
            return name  # the error is that of the `observe` statement
        raise BgError([scenes.plot_unobserved(path.span, name, list(known))])

    found = []
    for item in scene.statements(syntax.Plot):
        with world.report.collecting():
            drawn = tuple(column(path) for path in item.columns)
            found.append(Plot(drawn, column(item.against) if item.against else "time"))
    return tuple(found)


def _solver(world: World, scene: Scene, solver: syntax.Solver) -> Solver:
    options: dict[str, Any] = {}
    for argument in solver.arguments:
        with world.report.collecting():
            if argument.name is None or isinstance(argument.value, syntax.Text):
                what = f"solver `{solver.name}`"
                raise BgError([scenes.device_option(argument.span, what)])
            name = argument.name
            if name not in SOLVER_OPTIONS:
                raise BgError([scenes.unknown_option(argument.span, name, tuple(SOLVER_OPTIONS))])
            if name in options:
                raise BgError([names.given_twice(argument.span, name, solver.arguments[0].span)])
            known = SOLVER_OPTIONS[name]
            value = constant_of(world, scene, argument.value, f"`{name}`", known.dimension)
            if not value > 0:
                raise BgError([scenes.not_positive(argument.span, f"`{name}`", value)])
            if (problem := known.problem(name, value, argument.span)) is not None:
                raise BgError([problem])
            options[name] = known.kind(value)
    return Solver(solver.name, **options)
