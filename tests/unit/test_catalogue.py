"""The rows of the catalogue: each has its page, and makes a whole diagnostic of any arguments.

The type checker compares the arguments of each call with the signature of its row. What it does
not see are the places in the texts: here each row is called with sample arguments of its types.
"""

import inspect
import pkgutil
import types
import typing
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from importlib import import_module
from itertools import product
from pathlib import Path

import pytest

from bgc.diagnostics import catalogue
from bgc.diagnostics.catalogue.causality import Connection
from bgc.diagnostics.catalogue.pages import pages, read_topic
from bgc.diagnostics.diagnostic import Label
from bgc.diagnostics.row import PLACE, Row, error, fill
from bgc.diagnostics.source import Source, Span
from bgc.grammar.language_words import WORDS

FOLDER = Path(catalogue.__file__).parent
TOPICS = [found.name for found in pkgutil.iter_modules(catalogue.__path__) if found.name != "pages"]
SPAN = Span(Source("a.bg", "model A { part : R(2 ohm); }\n"), 10, 14)


def rows_of(topic: str) -> dict[str, Row]:
    module = import_module(f"{catalogue.__name__}.{topic}")
    return {name: row for name, row in vars(module).items() if isinstance(row, Row)}


ROWS = {f"{topic}.{name}": row for topic in TOPICS for name, row in rows_of(topic).items()}


@pytest.mark.parametrize("topic", TOPICS)
def test_the_pages_of_a_topic_are_those_of_its_rows(topic):
    _, found = read_topic(FOLDER / f"{topic}.md")
    assert sorted({row.code for row in rows_of(topic).values()}) == list(found)


def test_pages_do_not_name_the_parameters_of_their_rows():
    public = {*WORDS, "lag", "step", "substeps"}
    named = [
        (row.code, name)
        for row in ROWS.values()
        for name in inspect.signature(row.function).parameters
        if name not in public and f"`{name}`" in pages()[row.code]
    ]
    assert named == []


def test_messages_are_one_line_without_a_full_stop():
    texts = [row.message for row in ROWS.values()]
    assert [text for text in texts if not text or text.endswith(".") or "\n" in text] == []


# --- sample arguments -------------------------------------------------------------------

SAMPLES: dict[object, tuple[object, ...]] = {
    str: ("part", "q0", ""),
    int: (1, 2, 1200),
    float: (0.5, 2.0),
    bool: (False, True),
    object: ("part", 3),
    type(None): (None,),
    Span: (SPAN,),
    Connection: (Connection("a", "J0", SPAN), Connection("b", "GY", SPAN)),
    Label: (Label(SPAN, "here"),),
}
CHOICES: dict[tuple[str, str], tuple[object, ...]] = {
    ("BG520", "solutions"): ("none", "many", "unclear"),
    ("BG531", "solutions"): ("none", "many", "unclear", "unpaired"),
    ("BG531", "derivative"): (None, (1, "x = 0"), (3, "x = 0")),
    ("BG321", "expected"): (0, 1, 2),
}


def samples(kind: object) -> tuple[object, ...]:
    """Return values of a type: of a sequence a short and a long one."""
    inner = typing.get_args(kind)
    match typing.get_origin(kind):
        case types.UnionType:
            return tuple(value for each in inner for value in samples(each))
        case origin if origin is tuple and inner[-1] is not Ellipsis:
            return tuple(zip(*(samples(each) * 3 for each in inner), strict=False))[:3]
        case origin if origin in (tuple, Sequence, Iterable, Collection):
            some = samples(inner[0])
            return (tuple(some[:1]), tuple(some) * 9)
        case origin if origin is Mapping:
            return (dict(zip(samples(inner[0]), samples(inner[1]), strict=False)),)
    return SAMPLES[kind]


def calls_of(row: Row) -> Iterator[dict[str, object]]:
    """Return arguments: each value of each parameter beside the first ones of the others."""
    hints = typing.get_type_hints(row.function)
    parameters = inspect.signature(row.function).parameters
    values = {name: CHOICES.get((row.code, name)) or samples(hints[name]) for name in parameters}
    firsts = {name: some[0] for name, some in values.items()}
    needed = {n: firsts[n] for n, p in parameters.items() if p.default is p.empty}
    yield needed
    for name, some in values.items():
        yield from (firsts | {name: value} for value in some)
    switches = [name for name in values if hints[name] is bool]
    for settings in product((False, True), repeat=len(switches)):
        yield firsts | dict(zip(switches, settings, strict=True))


@pytest.mark.parametrize("name", ROWS)
def test_a_row_makes_its_diagnostic_of_any_arguments(name):
    row = ROWS[name]
    for arguments in calls_of(row):
        made = row(**arguments)
        assert (made.code, made.severity) == (row.code, row.severity)
        texts = [made.message, made.note, made.help, *(label.text for label in made.labels)]
        assert all(type(text) is str for text in texts)
        assert [text for text in texts if PLACE.search(text)] == [], arguments
        assert made.span is None or isinstance(made.span, Span)


@pytest.mark.parametrize("name", ROWS)
def test_what_a_row_computes_is_used(name):
    row = ROWS[name]
    texts = (row.message, row.help, row.note, *row.labels.values())
    places = {place[1] for text in texts for place in PLACE.finditer(text)}
    fields = {"span", "note", "labels", "help", "edits"}
    parameters = inspect.signature(row.function).parameters
    for arguments in calls_of(row):
        computed = row.function(**arguments) or {}
        assert computed.keys() <= places | fields
        assert places <= computed.keys() | parameters.keys()


def test_places_of_a_text():
    values = {"kind": "R", "names": ["a", "b"], "x": 2.5, "runs": 1200}
    text = "{kind:an} at {names:listed}: {x:.2f} in {runs:counted run}, `{ .. }`, {names:quoted}"
    assert fill(text, values) == "an R at `a` and `b`: 2.50 in 1,200 runs, `{ .. }`, `a`, `b`"


def test_a_value_that_looks_like_a_place_stays_as_it_is():
    @error("BG999: no `{name}`", "write `{other}`")
    def row(name: str, other: str) -> None: ...

    made = row("{other}", "{name}")
    assert (made.message, made.help) == ("no `{other}`", "write `{name}`")


@pytest.mark.parametrize("arguments", [{}, {"name": "a", "more": 1}])
def test_wrong_arguments_are_refused(arguments):
    @error("BG999: no `{name}`")
    def row(name: str) -> None: ...

    with pytest.raises(TypeError):
        row(**arguments)
