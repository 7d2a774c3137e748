import re
from collections import Counter
from pathlib import Path

import click
import pytest
from manual import chapter_files

from bgc.diagnostics import catalogue
from bgc.diagnostics.catalogue.pages import find_page, pages
from bgc.reference.codes import GROUP
from bgc.reference.entry import Text
from bgc.runtime.cli.app import application

ROOT = Path(__file__).parents[2]


def test_every_page_tells_what_why_an_example_and_the_way_out():
    for code, page in pages().items():
        for paragraph in ("What: ", "Why: ", "Example: ", "Way out: "):
            assert f"\n{paragraph}" in page, f"{code} has no paragraph {paragraph}"


def test_each_part_of_a_page_is_a_paragraph():
    for code in pages():
        blocks = [block.text for block in GROUP.entry(code).body if isinstance(block, Text)]
        starts = [text.partition(": ")[0] for text in blocks]
        assert [s for s in starts if s in ("What", "Why", "Example", "Way out")] == [
            "What", "Why", "Example", "Way out",
        ], code  # fmt: skip


def texts_that_name_commands() -> list[Path]:
    topics = Path(catalogue.__file__).parent
    return [
        *topics.glob("*.py"),
        *topics.glob("*.md"),
        *(ROOT / name for name in ("README.md", "grammar/LANGUAGE.md", "tests/README.md")),
        *chapter_files(),
        ROOT / "grammar/manual/topics.md",
        *(ROOT / "library/examples").glob("*.md"),
    ]


def test_commands_and_options_that_texts_name_exist():
    context = click.Context(application)
    options = {
        name: {"--help", *(text for p in command.params for text in (*p.opts, *p.secondary_opts))}
        for name in application.list_commands(context)
        if (command := application.get_command(context, name)) is not None
    }
    wrong = [
        f"{path.name}: bgc {command}{option and ' ' + option}"
        for path in texts_that_name_commands()
        for command, rest in re.findall(
            r"`bgc ([a-z]+)\b([^`]*)`", re.sub(r"\s+", " ", path.read_text("utf-8"))
        )
        for option in ("", *re.findall(r"(?<![\w-])--[a-z-]+", rest))
        if command not in options or (option and option not in options[command])
    ]
    assert wrong == []


def test_no_code_has_two_pages():
    files = Path(catalogue.__file__).parent.glob("*.md")
    headings = [
        h for file in files for h in re.findall(r"^## (.*?):", file.read_text("utf-8"), re.M)
    ]
    assert [code for code, count in Counter(headings).items() if count > 1] == []


def codes_in(paths, pattern: str) -> set[str]:
    return {code for path in paths for code in re.findall(pattern, path.read_text("utf-8"))}


def test_every_code_has_its_home_in_the_tests():
    """Its home is a file in `wrong/`; a unit test, where no text of a model can show it."""
    tests = Path(__file__).parents[1]
    files = [*tests.rglob("test_*.py"), *tests.glob("wrong/*.bg")]
    files.remove(Path(__file__))
    expected = codes_in(files, r"""(?:["'\[]|error: |warning: )(BG\d{3})""")
    assert sorted(pages().keys() - expected) == []


@pytest.mark.parametrize("code", ["BG055", "bg055"])
def test_pages_are_found_in_any_case(code):
    page = find_page(code)
    assert page is not None and page.startswith("BG055: ")


def test_what_is_no_code_has_no_page():
    assert find_page("hello") is None
