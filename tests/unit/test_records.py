"""The record of a run: what follows from its fields says the same everywhere."""

from __future__ import annotations

import dataclasses
import inspect
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import get_args

import click
import pytest
from parsed import read

import bgc
from bgc.building.build_result import Built, Place, Places, RunFacts, ShownNames, run_facts
from bgc.building.record_json import from_json, to_json
from bgc.diagnostics.diagnostic import BgError, Diagnostic, Label, Severity
from bgc.diagnostics.source import Source, Span
from bgc.grammar import syntax
from bgc.grammar.scene_statements import SCENE_STATEMENTS, expressions_in
from bgc.ir.port_facts import ForceFacts, PortFacts
from bgc.language.column_names import AccountColumn
from bgc.language.records import Where, options_of
from bgc.language.scene import Plot, Rest, Sampled, Scene
from bgc.language.solver import SOLVER_OPTIONS, Solver, SolverKeywords
from bgc.reference.word_entries import solver_options
from bgc.runtime.cli.command import Value
from bgc.runtime.cli.run import run
from bgc.runtime.model import Model
from bgc.runtime.realtime.loop import Realtime

REFERENCE = Path(__file__).parents[2] / "grammar/manual/reference"


def table_of_options() -> list[tuple[str, ...]]:
    """The table of `bgc doc solver`."""
    table = solver_options()
    rows = (
        (f"`{name}`", unit or "-", default, f"`{flag}`" if flag else "", doc)
        for name, unit, default, flag, doc in table.rows
    )
    return [table.header, *rows]


def table_of_statements() -> list[tuple[str, ...]]:
    """The forms, the meaning and the number of each statement of a scene."""
    rows = (
        (
            " or ".join(re.findall("`[^`]+;`", row.form)),
            row.summary[0].lower() + row.summary[1:].rstrip("."),
            row.often,
        )
        for row in SCENE_STATEMENTS.values()
    )
    return [("statement", "does", "how often"), *rows]


@pytest.mark.parametrize(
    ("chapter", "name", "table"),
    [
        ("solvers.md", "options of a solver", table_of_options),
        ("scenes.md", "statements of a scene", table_of_statements),
    ],
)
def test_the_tables_of_the_manual_are_those_of_the_records(
    chapter: str, name: str, table: Callable[[], list[tuple[str, ...]]], bless: bool
) -> None:
    place = re.compile(rf"(?sm)(?<=^<!-- {name}: )(.*?-->\n)(.*?)(?=^<!-- end -->)")
    header, *rows = table()
    lines = (f"| {' | '.join(row)} |\n" for row in (header, ("---",) * len(header), *rows))
    written = f"\n{''.join(lines)}\n".replace("|  |", "| |")
    text = (REFERENCE / chapter).read_text("utf-8")
    if bless:
        (REFERENCE / chapter).write_text(place.sub(lambda m: m[1] + written, text), "utf-8")
        return
    found = place.search(text)
    assert found is not None and found[2] == written


def test_each_statement_of_a_scene_has_a_row_that_fits_its_node_and_the_record() -> None:
    rows = SCENE_STATEMENTS.values()
    assert {row.node for row in rows} == set(get_args(syntax.SceneItem))
    for row in rows:
        known = {field.name for field in dataclasses.fields(row.node)}
        assert known.issuperset({row.key or "span", *row.paths}), row.word
        assert (row.node is syntax.Fact) == bool(row.gives), row.word
    stated = [name for row in rows for name in row.gives]
    options = options_of(Scene, Where.SCENE)
    assert sorted(stated) == sorted(options)
    assert all(option.noun or option.choices for option in options.values())


def test_expressions_of_a_statement_are_those_of_its_fields() -> None:
    text = 'use a = T[m](b = c); device d = trace("f", k); start rest hold x, y vary z;'
    (scene,) = read(f"scene s of M {{ {text} }}").declarations
    found = [[e.span.text for e in expressions_in(item)] for item in scene.items]
    assert found == [["a", "T[m](b = c)"], ['"f"', "k"], ["x", "y", "z"]]
    (*_, start) = scene.items
    assert [e.span.text for e in expressions_in(start, {"vary"})] == ["z"]


def test_keywords_are_the_fields_that_python_may_give() -> None:
    known = [option.keyword for option in options_of(Solver, Where.PYTHON).values()]
    assert list(SolverKeywords.__annotations__) == known


@pytest.mark.parametrize(
    "function",
    [
        *(Model.simulate, Model.realtime, Model.step, Model.simulate_many, Model.sweep),
        *(Model.fit, Model.optimise, Model.operability, Realtime.exchange),
    ],
    ids=lambda function: function.__name__,
)
def test_functions_show_and_explain_each_keyword(function) -> None:
    parameters = inspect.signature(function).parameters
    assert not any(p.kind is p.VAR_KEYWORD for p in parameters.values())
    for keyword in SolverKeywords.__annotations__:
        assert parameters[keyword].kind is inspect.Parameter.KEYWORD_ONLY
        assert re.search(rf"\b{keyword}\b", function.__doc__)
    assert "**run" not in function.__doc__
    for keyword in (option.keyword for option in options_of(Scene, Where.PYTHON).values()):
        assert keyword not in parameters or re.search(rf"\b{keyword}\b", function.__doc__)


def test_commands_have_the_options_of_the_record_with_its_texts() -> None:
    options = {o.name: o for o in run.params if isinstance(o, click.Option)}
    for record in (Solver, Scene):
        for known in options_of(record, Where.COMMAND).values():
            shown = options[known.keyword]
            assert shown.help == known.help and shown.opts == [known.flag]
            assert isinstance(shown.type, Value) == bool(known.unit)


def test_an_unknown_keyword_is_refused_with_the_nearest(tmp_path: Path) -> None:
    model = bgc.compile(Path(__file__).parents[1] / "models/duffing.bg")
    for wrong, right in (("rtoll", "rtol"), ("duraton", "duration")):
        message = rf"`simulate` got .* keyword argument `{wrong}`; did you mean `{right}`"
        with pytest.raises(TypeError, match=message):
            model.simulate(**{wrong: 1.0})


def test_a_least_step_above_the_longest_is_refused() -> None:
    model = bgc.compile(Path(__file__).parents[1] / "models/duffing.bg")
    with pytest.raises(
        bgc.BgError, match=r"`min_step` is 0\.002, which is not at most `max_step`, 0\.001"
    ):
        model.simulate("1 s", min_step="2 ms", max_step="1 ms")


@pytest.mark.parametrize("value", [0, -3, 2.5, 1001])
def test_a_number_of_parts_says_what_it_may_be(value: float) -> None:
    problem = SOLVER_OPTIONS["substeps"].problem("substeps", value)
    assert problem is not None
    assert problem.message.endswith("which is not a positive whole number up to 1000")


@pytest.mark.parametrize("name", SOLVER_OPTIONS)
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf")])
def test_no_option_takes_what_is_no_positive_number(name: str, value: float) -> None:
    problem = SOLVER_OPTIONS[name].problem(name, value)
    assert problem is not None and problem.code == "BG066"


def test_ranges_and_whole_numbers() -> None:
    good = {"rtol": (1e-15, 0.5), "substeps": (1, 1000), "keep": (1, 7), "max_steps": (1, 2e9)}
    bad = {"rtol": (9e-16, 0.51), "substeps": (1.5, 1001), "keep": (0.5,), "max_steps": (3e9,)}
    for name, values in good.items():
        assert [SOLVER_OPTIONS[name].problem(name, value) for value in values] == [None] * len(
            values
        )
    for name, values in bad.items():
        assert all(SOLVER_OPTIONS[name].problem(name, value) for value in values)


def test_a_scene_is_refused_where_its_option_is_out_of_range(tmp_path: Path) -> None:
    path = tmp_path / "m.bg"
    path.write_text(
        "model M { state x = 1; der(x) = -x; }\n"
        "scene s of M { observe x; solver rk4(substeps = 2.5); step 1 ms; run 1 s; }\n"
    )
    with pytest.raises(BgError) as caught:
        bgc.compile(path)
    (problem,) = caught.value.diagnostics
    assert problem.code == "BG066" and problem.span.text == "substeps = 2.5"


SOURCE = Source("m.bg", "model M { }")
SPAN = Span(SOURCE, 0, 5)
SCENE = Scene(
    "s",
    "M",
    ("a", "energy.stored [kJ]"),
    (AccountColumn("stored", "energy.stored [kJ]", "kJ", 1e3),),
    Solver("ros34prw", step=1e-3, substeps=4),
    duration=float("inf"),
    plots=(Plot(("a",), "time"),),
    rest=Rest(("a",), ("m",), (0, 2), (Sampled(1, "held", "N"),)),
    criteria=("max(a) < 3.0 N",),
)
FACTS = run_facts(
    SCENE,
    folded=(("m", 0.0),),
    passive=(("m", "the mass", "I"),),
    shown=ShownNames(outputs=(("a", "mm", 1e-3),)),
    ports=(PortFacts("p", (1,), (2, 3)),),
    forces=(ForceFacts("hand", ("p",), whole=True, periods=("T", 0.01)),),
    slots=(("a.b", "C"),),
)


def test_a_note_of_the_cache_gives_back_what_was_written() -> None:
    warning = Diagnostic("BG1", Severity.WARNING, "so", SPAN, labels=(Label(SPAN, "here"),))
    places = Places((Place(SPAN, ("x",)), Place(None)), loops=((("x",), ("R", "C")),))
    texts = {"m.bg": SOURCE.text}
    for kind, value in ((RunFacts, FACTS), (Diagnostic, warning), (Places, places)):
        assert from_json(kind, json.loads(json.dumps(to_json(value))), texts) == value


@pytest.mark.parametrize(
    "damage",
    [
        lambda note: note.pop("name"),
        lambda note: note.update(unknown=1),
        lambda note: note["solver"].update(keep=2.5),
        lambda note: note["solver"].update(rtol="1e-6"),
        lambda note: note.update(solver=[]),
        lambda note: note["rest"].update(momenta=["x"]),
        lambda note: note.update(plots=3),
        lambda note: note.update(timed=None),
    ],
)
def test_a_damaged_note_is_refused(damage) -> None:
    note = to_json(FACTS)
    damage(note)
    with pytest.raises((KeyError, TypeError, ValueError)):
        from_json(RunFacts, note)


def test_facts_are_the_record_with_what_compilation_adds() -> None:
    assert isinstance(FACTS, Scene)
    assert Built(Path("m.so"), FACTS).facts.solver is SCENE.solver
    assert FACTS.rest_for("") == SCENE.rest and FACTS.rest_for("given") is None
    assert run_facts(Scene("s", "M", ())).rest_for("") is None
    assert run_facts(Scene("s", "M", ())).rest_for("rest") == Rest()
