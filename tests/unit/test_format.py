"""`bgc fmt`: canonical, idempotent, and without a change of meaning or a lost comment."""

from __future__ import annotations

import random
import re
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from refusals import codes_of

from bgc.diagnostics.source import Source, Span
from bgc.grammar.format import format_source
from bgc.grammar.parse import parse, parse_with_tokens, read_source

ROOT = Path(__file__).parents[2]
MODELS = sorted([*ROOT.glob("library/**/*.bg"), *ROOT.glob("tests/models/**/*.bg")])

UNTIDY = """\
import   "a.bg" ;   // joints


// lead
/// Doc.
model RLC [n=3,m]   is  B [ 2 ]( a=3 )
{

  param R=2 ohm;   /* inner */ param L : mH=1 mH in 0 mH..3 mH ; // trail
  supply : Se(e=5 V); loop : J1;
  coil[i] : I ( L ) ;



  map : MTF { f2=J*f1; };
  law2 : C {
    H=k/2*q ^ 2 + 3 m * l - -x; // energy

    // last
  }
  arm : Slew2R(l1 = 12 m, // first
     q = [ a.angle,
          b.angle],
     /* own */
     l2 = 9 m
     + 2 m
     );
  for i in 1 .. n { a->b; if i<3 { c->d; } else { d -> e; } }
  for i in 1..n {
  a -> b[1 .. 3],c ; }
  if a==3 { x -> y; } // c1
  else { z -> w; }
  let z = if not(a<3)and b then -2^-2 else transpose( A )[ 1 ,2 ].x*(3-c);
  supply->loop
    -> coil;
}
model Osv is Vessel(M=3){ when  -x>0{ reset y=1; } when x > 3 m
{
reset y=1 ;reset z.p= - y;}
sample  T{ state i=0;next( i )=i+1; }
sample 10 ms offset   2 ms
{
next(i)=i + -1 ;}
shape   box( 1 m,w , 2 m )at c ,eye(3)   colour"red" ;
shape rope   from a.tip
 to b;
}
scene s of A {observe energy.stored as e,b ; run 10 s every 10 ms;}
"""

TIDY = """\
import "a.bg";  // joints

// lead
/// Doc.
model RLC[n = 3, m] is B[2](a = 3) {
  param R = 2 ohm; /* inner */
  param L : mH = 1 mH in 0 mH .. 3 mH;  // trail
  supply  : Se(e = 5 V);
  loop    : J1;
  coil[i] : I(L);

  map  : MTF { f2 = J*f1; }
  law2 : C {
    H = k/2*q^2 + 3 m * l - -x;  // energy

    // last
  }
  arm : Slew2R(l1 = 12 m,  // first
    q = [a.angle,
      b.angle],
    /* own */
    l2 = 9 m
      + 2 m
  );
  for i in 1..n { a -> b; if i < 3 { c -> d; } else { d -> e; } }
  for i in 1..n {
    a -> b[1..3], c;
  }
  if a == 3 { x -> y; }  // c1
  else { z -> w; }
  let z = if not (a < 3) and b then -2^-2 else transpose(A)[1, 2].x*(3 - c);
  supply -> loop
    -> coil;
}
model Osv is Vessel(M = 3) {
  when -x > 0 { reset y = 1; }
  when x > 3 m {
    reset y = 1;
    reset z.p = -y;
  }
  sample T { state i = 0; next(i) = i + 1; }
  sample 10 ms offset 2 ms {
    next(i) = i + -1;
  }
  shape box(1 m, w, 2 m) at c, eye(3) colour "red";
  shape rope from a.tip
    to b;
}
scene s of A { observe energy.stored as e, b; run 10 s every 10 ms; }
"""


def formatted(text: str) -> str:
    return format_source(Source("test.bg", text))


def meaning(node: Any) -> Any:
    """A syntax tree without its places."""
    if is_dataclass(node):
        kept = [(f.name, getattr(node, f.name)) for f in fields(node)]
        return type(node).__name__, [
            (name, meaning(value)) for name, value in kept if not isinstance(value, Span | Source)
        ]
    return [meaning(child) for child in node] if isinstance(node, tuple) else node


def comments(text: str) -> list[str]:
    return [re.sub(r"\s+", " ", c) for c in re.findall(r"//[^\n]*|/\*.*?\*/", text, re.DOTALL)]


def check(text: str) -> None:
    """Formatting keeps meaning and comments, and formatting again changes nothing."""
    once = formatted(text)
    assert formatted(once) == once
    before, _ = parse(Source("test.bg", text))
    after, wrong = parse(Source("test.bg", once))
    assert not wrong
    assert meaning(after) == meaning(before)
    assert comments(once) == comments(text)
    assert not re.search(r"[ \t]$|\n\n\n|\A\n|\n\n\Z", once.replace("\r", ""), re.MULTILINE)


def test_untidy_text_becomes_tidy() -> None:
    assert formatted(UNTIDY) == TIDY
    check(UNTIDY)


@pytest.mark.parametrize("path", MODELS, ids=lambda path: path.stem)
def test_models_of_the_repository(path: Path) -> None:
    text = read_source(path).text
    check(text)
    assert formatted(text) == text, f"run `bgc fmt {path.relative_to(ROOT)}`"


def test_nothing_stays_nothing() -> None:
    assert formatted("") == ""
    assert formatted("\n \n") == ""
    assert formatted("// only this") == "// only this\n"


def test_wrong_text_is_refused_with_its_errors() -> None:
    assert codes_of(formatted, "model A { let y = 5V; }") == ["BG106"]


def test_long_block_leaves_its_line() -> None:
    law = "f2 = " + " + ".join(["value"] * 12) + ";"
    text = formatted(f"model A {{\n  map : MTF {{ {law} }}\n}}")
    assert text == f"model A {{\n  map : MTF {{\n    {law}\n  }}\n}}\n"
    check(text)


@pytest.mark.parametrize(
    "value",
    [
        "3 m * l", "3 m ^ 2", "3 m / 2", "(3 m)^2", "2*3 m", "a- -b", "- - b", "a*-b", "x[1.. .5]",
        "10 / s", "a /* b */ / c", "3 m /* c */ *2", "a // c\n + b", "[1,\n 2\n]", "f(a = [1,\n2])",
        "if a then - b else not c", "a<-b", "block([\n[a], [b]\n])", "f(\n// c\n)",
        "[1, 2]m", "[1, 2]  m/s*k", "[[1], [2]] // c\n kN - x", "[1, 2] m / 2 m",
    ],
)  # fmt: skip
def test_value_keeps_its_meaning(value: str) -> None:
    check(f"model A {{ let y = {value}; }}")


@pytest.mark.parametrize(
    "text",
    [
        "model A { /* a */ param k = 1; /* b */ param l = 2; // c\n /// d\n port p; }",
        "model A { // {\n\n param k = 1;\n\n }\n\n\n// end",
        "/* two\n   lines */ model A { a : R { /* x */ e = f; } // y\n}",
        "model A { if a { } // c\n else { } /* d */ }",
        "model A { r : R { e = f; } // c\n ; port p; }",
        "model A // c\n { port p // d\n ; }",
        "import a /* b */ . c ; /// no doc\n/// doc\n\nmodel A { }",
        "model A {\r\n  port p;\r\n}\r\n",
        "model A { when /* c */ x > 0 { reset y = 1; } sample // d\n T { next /* e */ (i) = 1; } }",
    ],
)
def test_comments_stay(text: str) -> None:
    check(text)


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_any_layout_of_the_same_tokens(seed: int) -> None:
    """Blanks, line ends and comments between the tokens may be any."""
    rng = random.Random(seed)
    _, tokens, _ = parse_with_tokens(Source("test.bg", TIDY))
    gaps = [" ", "  ", "\n", "\n\n\n", " // c\n", "\n// own\n", " /* b */ ", "\n/* b\n b */ "]
    text = "".join(str(token) + rng.choices(gaps, [12, 3, 4, 1, 1, 1, 1, 1])[0] for token in tokens)
    check(text)
