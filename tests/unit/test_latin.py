"""Names of files in other alphabets, as names in the language and in C."""

from __future__ import annotations

from pathlib import Path

import pytest

from bgc.grammar.latin import latin
from bgc.runtime.fmi.fmu_model import identifier_of
from bgc.runtime.importing.identifiers import Names


@pytest.mark.parametrize(
    ("text", "written"),
    [
        ("käse", "kaese"),
        ("ka\u0308se", "kaese"),
        ("kase", "kase"),
        ("Übergrößenträger", "Uebergroessentraeger"),
        ("Sjøkran-Ålesund", "Sjoekran-Aalesund"),
        ("café ½", "cafe 12"),
        ("中梁", "u4e2du6881"),
        ("a b.c_1", "a b.c_1"),
    ],
)
def test_letters_become_ascii_letters(text, written) -> None:
    assert latin(text) == written
    assert written.isascii()


def test_exports_and_imports_spell_names_alike() -> None:
    assert identifier_of(Path("käse.bg"), None) == Names().value("käse") == "kaese"
    assert identifier_of(Path("kase.bg"), None) == "kase"
    assert identifier_of(Path("梁.bg"), "größe") == "u6881_groesse"
    assert Names().type("große kran") == "GrosseKran"
