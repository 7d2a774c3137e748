"""What is said of other tools names what exists; `statements_of_other_tools` of wrong has it."""

from __future__ import annotations

import re

from manual import whole_manual

from bgc.driver import check_source
from bgc.grammar.peers import _PARTS, _STORES, element_advice
from bgc.language.elements import ELEMENTS
from bgc.resolution.resolve import _library_index


def test_a_mistake_in_braces_is_reported_once(tmp_path) -> None:
    file = tmp_path / "m.bg"
    file.write_text("model M { param x[3] = {1, 2, 3}; param k = 3; }")
    assert len(list(check_source(file))) == 1


def test_parts_of_other_libraries_stand_for_parts_that_exist() -> None:
    """Those of messages, and those of the manual's table."""
    chapter = whole_manual().partition("## Parts of other libraries\n")[2].partition("\n#")[0]
    cells = [line.rsplit(" | ", 1)[1] for line in chapter.splitlines() if line.startswith("| ")]
    named = {name for cell in cells for name in re.findall(r"`([A-Z]\w*)(?:\[n\])?`", cell)}
    library = {*_library_index(), *ELEMENTS}
    assert len(named) > 50 and named <= library, named - library
    assert set(_PARTS.values()) <= library, set(_PARTS.values()) - library


def test_the_advice_names_elements_that_exist() -> None:
    for words in _STORES.values():
        for word in words.split():
            assert element_advice(word).split("`")[1] in ELEMENTS
    assert not any(element_advice(name) for name in ELEMENTS)
