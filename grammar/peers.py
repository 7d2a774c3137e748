"""Words of textbooks and of other tools, with what stands for them in the language.

Someone who comes from Modelica, 20-sim, Simscape or a textbook tries these words first. A message
about an unknown name takes its way out from here.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

_STORES = {
    "I": "mass inertia inductor inductance flywheel pointmass body",
    "C": "spring capacitor capacitance compliance tank",
    "R": "damper resistor resistance friction dashpot resistive",
    "J0": "zerojunction junction0 zero onejunctionzero parallel node ejunction",
    "J1": "onejunction junction1 one series fjunction",
    "TF": "transformer lever gear idealgear pulley",
    "GY": "gyrator motor emf",
    "Se": "effortsource sourceeffort voltagesource forcesource torquesource pressuresource "
    "constantvoltage battery",
    "Sf": "flowsource sourceflow currentsource velocitysource speedsource pumpsource",
    "MTF": "modulatedtransformer",
    "MGY": "modulatedgyrator",
    "MR": "modulatedresistor",
    "Mux": "multiplexer multiplex",
    "Demux": "demultiplexer demultiplex",
}

_ELEMENT_OF: Mapping[str, str] = {
    word: element for element, words in _STORES.items() for word in words.split()
}

_VALUES: Mapping[str, str] = {
    "t": "the time is `time`",
    "Time": "the time is `time`",
    "PI": "the number is `pi`",
    "Pi": "the number is `pi`",
    "true": "write a condition, such as `1 > 0`",
    "false": "write a condition, such as `1 < 0`",
}

_PATH = r"[A-Za-z_][\w.]*(?:\[[^\]\n]*\])?"
_TYPE = r"(?!(?:model|scene|param|const)\b)([A-Za-z]\w*)"
_STATEMENTS: tuple[tuple[re.Pattern[str], str], ...] = tuple(
    (re.compile(written), advice)
    for written, advice in (
        (rf"connect\s*\(\s*({_PATH})\s*,\s*({_PATH})\s*\)", r"a bond is an arrow: `\1 -> \2;`"),
        (rf"({_PATH})\s*(?:<-|<--|<->|--|-->|=>)\s*({_PATH})", r"a bond is an arrow: `\1 -> \2;`"),
        (r"end\b", "a block ends with `}`"),
        (
            r"model\s+(\w+)\s+(?!is\b)[A-Za-z_]",
            r"the body of a model stands in braces: `model \1 { .. }`",
        ),
        (r"(?:Real|var|variable)\s+(\w+)", r"a variable is `state \1 = 0;`, `let` or `unknown`"),
        (r"initial\s+(\w+)", r"a start value stands at its declaration: `state \1 = ..;`"),
        (r"d(\w+)/dt\b", r"a derivative is `der(\1) = ..;`"),
        (r"(\w+)'\s*=", r"a derivative is `der(\1) = ..;`"),
        (r"([01])-?junction\s+(\w+)", r"a junction is `\2 : J\1;`"),
        (r"(\w+)\s*:\s*([01])(?:-?junction)?\b", r"a junction is `\1 : J\2;`"),
        (
            rf"(\w+)\s*,\s*(\w+)\s*:\s*{_TYPE}",
            r"each part is declared by itself: `\1 : \3; \2 : \3;`",
        ),
        (rf"{_TYPE}\s+(\w+)\s*\(", r"a part is `\2 : \1(..);`"),
        (rf"{_TYPE}\s+(\w+)\s*;", r"a part is `\2 : \1;`"),
    )
)
"""Statements of peers, by their beginning, each with the way to write it here."""


def statement_advice(text: str) -> str:
    """Advise on a statement of a peer, `text` from its first character on; else an empty text."""
    for written, advice in _STATEMENTS:
        if found := written.match(text):
            return found.expand(advice)
    return ""


def element_advice(name: str) -> str:
    """Name the element that a word of a peer stands for; an empty text if there is none.

    Letter case, underscores and hyphens do not count: `OneJunction`, `one_junction`.
    """
    element = _ELEMENT_OF.get(name.casefold().replace("_", "").replace("-", ""))
    return f"the element is called `{element}` here: see `bgc doc {element}`" if element else ""


def value_advice(name: str) -> str:
    """Name the value that a word of a peer stands for; an empty text if there is none."""
    return _VALUES.get(name, "")
