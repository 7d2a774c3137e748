"""The pages of the site: every link of the repository's Markdown leads somewhere in it."""

import inspect
import re
import sys
from pathlib import Path

import pytest

SITE = Path(__file__).parents[2] / ".site"
if not SITE.is_dir():
    pytest.skip("not a checkout", allow_module_level=True)
sys.path.insert(0, str(SITE))
sys.path.insert(1, str(Path(__file__).parents[1] / "bench"))

from check_links import broken_links  # noqa: E402
from curves_page import Point, exponent  # noqa: E402
from figures import benchmarks, read_points  # noqa: E402
from make import configuration, every_page, write_pages  # noqa: E402
from needs import browser, missing, stop_if_missing  # noqa: E402
from pages import Links, Page, anchors_of, one_page, written  # noqa: E402
from python_api import TOPICS, documented, found, python_pages, shown_name  # noqa: E402

import bgc  # noqa: E402
from bgc.runtime import control  # noqa: E402

INDEX = """\
# Manual

See [the end](bonds.md#the-end), `a[1](b)` and [bonds](bonds.md).
"""
BONDS = """\
# Bonds

```bg rlc.bg error BG301
# not a heading [x](y)
```

## The end

Back to [the
start](M.md#manual), [here](#bonds), [a picture](../a.svg).
"""


def test_files_become_pages_whose_links_hold():
    pages = [
        *one_page("manual/index.md", "Overview", "grammar/M.md", INDEX),
        *one_page("manual/learn/bonds.md", "Bonds", "grammar/bonds.md", BONDS),
    ]
    places = {page.source: page.path for page in pages}
    links = Links({**places, **dict(anchors_of(pages))}, lambda f: f"files/{f}")
    start, bonds = (written(page, links) for page in pages)
    assert "[the end](learn/bonds.md#the-end), `a[1](b)` and [bonds](learn/bonds.md)" in start
    assert bonds.startswith("# Bonds {#bonds}\n")
    assert '```bg title="rlc.bg"\n# not a heading [x](y)\n```\n' in bonds
    assert "## The end {#the-end}" in bonds
    assert (
        "start](../index.md#manual), [here](bonds.md#bonds), [a picture](../../files/a.svg)"
        in bonds
    )
    lost = Page("manual/lost.md", "Lost", "grammar/M.md", ["[x](#nowhere)"])
    with pytest.raises(LookupError, match="nothing in the site is #nowhere"):
        written(lost, links)


def test_every_page_of_the_repository_is_written(tmp_path):
    parts = write_pages(tmp_path, scenes=[])
    every = [*every_page(parts)]
    assert len({page.path for page in every}) == len(every) > 150
    assert all((tmp_path / page.path).read_text("utf-8").startswith("#") for page in every)
    assert {page.path for page in every if len("\n".join(page.lines).split()) > 6000} == set()
    topics = (tmp_path / "topics.md").read_text("utf-8")
    assert "\n## LQR, LQG, pole placement" in topics
    assert "[marine.response](library/marine/response.md)" in topics
    settings = configuration(parts)
    assert all(f'"{page.path}"' in settings for page in every)
    notebook = (tmp_path / "tutorials/notebook.md").read_text("utf-8")
    assert "<div><svg" in notebook and "data:image/png" in notebook
    assert "```text\n1591.549430918" in notebook  # 1/(2 pi sqrt(L C))


def test_a_thing_that_the_site_needs_and_lacks_has_one_message(monkeypatch, capsys):
    assert list(missing((("bgc", "pip install ."),), ())) == []
    monkeypatch.setenv("PATH", "")
    monkeypatch.setenv("CC", "no_such_compiler")
    with pytest.raises(SystemExit) as ended:
        stop_if_missing(("no_such_module", 'pip install ".[site]"'), programs=("dot",))
    assert ended.value.code == 1
    packages, program, compiler = capsys.readouterr().err.splitlines()
    assert packages == 'the package no_such_module is missing: pip install ".[site]"'
    assert program.startswith("the program dot is missing: install Graphviz")
    assert compiler.startswith("the C compiler is missing: ") and "no_such_compiler" in compiler
    with pytest.raises(SystemExit):
        browser()
    assert capsys.readouterr().err.startswith("a browser is missing: install one of chromium")


def test_broken_links_are_found(tmp_path):
    (tmp_path / "a.html").write_text(
        '<h1 id="top">A</h1><a href="b.html#here">b</a><a href="#top">top</a><a href="c.html">c</a>'
        '<a href="b.html#gone">b</a><script src="https://a.test/x.js"></script>'
        '<a href="https://a.test">elsewhere</a>'
    )
    (tmp_path / "b.html").write_text('<p id="here">B</p>')
    assert broken_links(tmp_path) == [
        "a.html: b.html#gone: no such heading",
        "a.html: c.html: no such file",
        "a.html: https://a.test/x.js: from another host",
    ]


def test_benchmarks_show_all_recorded_numbers(tmp_path):
    recorded = Path(__file__).parents[1] / "bench" / "curves.csv"
    points = read_points(recorded)
    (page,) = benchmarks(tmp_path, recorded)
    text = "\n".join(page.lines)
    assert len(points) > 30
    rows = [line for line in page.lines if line.startswith("| ")]
    for p in points:
        assert any(
            line.startswith(f"| {p.tool} |") and f" {p.value:.3g} |" in line for line in rows
        )
    for figure in {p.figure for p in points}:
        assert f"(benchmarks/{figure}.svg)" in text
        drawing = (tmp_path / "benchmarks" / f"{figure}.svg").read_text()
        assert drawing.count("<path") > 10


def test_growth_is_the_exponent_of_the_size():
    points = [Point("rates", "arm", "our f", n, 3.0 * n**1.5, "here") for n in (4, 8, 16)]
    assert abs(exponent(points) - 1.5) < 1e-12
    assert exponent(points[:1]) is None


def test_every_public_name_of_python_has_a_text_that_explains_its_arguments():
    """An argument is named in the docstring; a `path` or a `name` explains itself."""
    every = [name for _, _, names in TOPICS for name in names]
    assert {f"bgc.{name}" for name in bgc.__all__} <= {*every, "bgc.control"}
    assert {f"bgc.runtime.control.{name}" for name in control.__all__} <= set(every)
    for where in every:
        thing = found(where)
        members = dict(documented(thing)) if inspect.isclass(thing) else {"": thing}
        assert inspect.getdoc(thing)
        for name, member in members.items():
            text = inspect.getdoc(member)
            assert text, f"{where}.{name} has no docstring"
            given = inspect.signature(member).parameters if inspect.isfunction(member) else ()
            for argument in set(given) - {"self", "path", "name", "file"}:
                assert re.search(rf"\b{argument}\b", text), f"{where}.{name}: {argument}"


def test_pages_of_python_have_signatures_definitions_and_examples():
    pages = {page.path: "\n".join(page.lines) for page in python_pages()}
    text = pages["python/model.md"]
    assert "start: Literal['rest', 'given'] | None = None,\n" in text
    assert "`solver`\n:   Integration method" in text
    assert "[BG760](../diagnostics/bg750.md#bg760)" in text
    assert '```python\nresult = model.simulate("2 s", parameters={"R": "5 ohm"})\n' in text
    assert "doctest" not in text and ">>>" not in text
    assert "### `parameters`" not in text and "Run-time parameters by name" in text  # inherited
    assert "instance_at" not in text  # for other modules
    assert "## `control.margins` {#control-margins}" in pages["python/control.md"]
    for name in ("Quantity", "ParameterValue", "Inputs", "Vary"):
        assert f"\n`{name}`\n:   " in pages["python/index.md"]
    shown = [shown_name(name) for _, _, names in TOPICS for name in names]
    assert len(set(shown)) == len(shown)
