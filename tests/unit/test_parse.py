"""The parser: what is read, what is refused with which words, and that nothing breaks it."""

from __future__ import annotations

import random
import re
from fractions import Fraction
from pathlib import Path

import pytest

from bgc.diagnostics.render import render
from bgc.diagnostics.report import MAX_ERRORS
from bgc.diagnostics.source import Source, Span
from bgc.grammar import syntax
from bgc.grammar.lark_parser import build_parser
from bgc.grammar.parse import parse, parse_with_tokens, read_source
from bgc.grammar.syntax import Binary, Call, Index, Member, Name, Number, Range, TypeUse, Unary
from bgc.grammar.words import BLOCK_OF, FORMS_IN, RESERVED, WORDS

ROOT = Path(__file__).parents[2]

EVERYTHING = """
import "joints.bg";
import crane.joints;

const g = 9.81 m/s^2;
function skew(v) = [[0, -v[3], v[2]], [v[3], 0, -v[1]], [-v[2], v[1], 0]];
function half(x) =
  if x > 0 and not (x == 1) then x/2 else if x < -1 or x != 3 then -x else 0;

/// A port in space.
domain Frame {
  effort F[3] : N; effort M[3] : N*m;
  flow v[3] : m/s; flow w[3] : rad/s;
  signal r[3] : m; signal A[3, 3];
}
pseudo domain Heat { effort T : K; flow Q : W; }

interface Lock[n] { port p[n]; output d[n]; }

/// Stiff
/// and damped.
model Compliant[n = 6, m] is Lock[n](k = 3) {
  const c = 3;
  param axis[3] = [0, 0, 1];
  param mass : kg = 1 t in 0 t .. 100 t;
  let l = 2*mass;
  signal r[3] : m = [time, 0, .5];
  input q[2];
  output d[n];
  state x : m = 1;
  state A[3, 3];
  unknown z = 0;

  port base in : Frame;
  port tip[6] out : Frame main;
  port p;
  port side out;

  supply : Se(e = 5 V);
  loop   : J1;
  R      : R(R);
  body   : I[6](mass*eye(3), p0 = [0, 0]);
  mass[i + 1] : I(m);
  lock   : Lock[5] = Rigid[5](k = 1e9 N/m);
  slot   : Crane = TwoBeamCrane;
  joint  : Revolute(lock = Rigid[5](stiff = 1), other = Rigid(a = 1));
  drag   : R { e = d1*f + d2*abs(f)*f; }
  spring : C { H = k/2*q^2 + k3/4*q^4; };
  map    : MTF[2, 3] { f2[1..2] = J*f1; }
  nothing : J0 { }

  supply -> loop -> tip;
  a, b.c -> join -> hub[1..3], d[i];
  tip.r = base.r;
  der(x) = -x/2;
  der(x[1]) = 1;
  equation z^2 + der(x) = 0;
  project x = x/norm(x);
  assert x > 3 m, "too far";
  for i in 1..n - 1 { mass[i] -> mass[i + 1]; for j in 1..2 { } }
  if n == 3 { a -> b; } else if n < 2 { b -> a; } else { }
}
model Osv is Vessel(M = [[1, 2], [3, 4]]) { }

scene telescopic of Session(k = 1) {
  use crane = TelescopicCrane;
  use crane.elbow.lock = Rigid[5](k = 1);
  set crane.boom.mass = 7 t;
  device hand = trace(file = "up.csv", gain = 2);
  device omega = forcedimension;
  drive handle.x = hand.position;
  observe energy.stored, tip.z as height, 2*boom.f[1];
  require tip.z within 5 mm;
  plot height, tip.z;
  plot force[3] against height;
  keep x, crane.y;
  deadline 1 ms;
  solver rodas5p(rtol = 1e-8, atol = 1e-10);
  solver auto;
  step 1 ms;
  run 60 every 10 ms;
}
"""


def read(text: str) -> syntax.File:
    """The tree of a text that must be right."""
    file, wrong = parse(Source("test.bg", text))
    assert not wrong, render(wrong, colour=False)
    return file


def items(body: str) -> tuple[syntax.Item, ...]:
    """The items of a model."""
    (model,) = read(f"model M {{ {body} }}").declarations
    assert isinstance(model, syntax.Model)
    return model.items


def expression(text: str) -> syntax.Expr:
    """An expression, as the value of a `let`."""
    (item,) = items(f"let x = {text};")
    assert isinstance(item, syntax.Value)
    assert item.value is not None
    return item.value


def show(expr: syntax.Expr | Range) -> str:
    """An expression with all its parentheses."""
    match expr:
        case Number(value, unit):
            return f"{value}" if unit is None else f"{value}_{unit}"
        case Name(name):
            return name
        case Unary(operator, operand):
            return f"({operator}{show(operand)})"
        case Binary(operator, left, right):
            return f"({show(left)}{operator}{show(right)})"
        case Member(base, name):
            return f"{show(base)}.{name}"
        case Index(base, indices):
            return f"{show(base)}[{','.join(show(index) for index in indices)}]"
        case Range(first, last):
            return f"{show(first)}..{show(last)}"
        case Call(function, arguments):
            return f"{function}({','.join(show(argument) for argument in arguments)})"
    raise AssertionError(expr)


def wrong(text: str) -> list[tuple[str, str]]:
    """Code and underlined text of every diagnostic."""
    _, found = parse(Source("test.bg", text))
    assert all(d.help or d.labels for d in found), "a message without a way out"
    return [(d.code, d.span.text if d.span else "") for d in found]


def wrong_in_model(body: str) -> list[tuple[str, str]]:
    return wrong(f"model M {{ {body} }}")


# --- the grammar and its trees ----------------------------------------------------------


def test_grammar_has_no_conflicts() -> None:
    build_parser(strict=True)


def test_whole_language_is_read() -> None:
    file = read(EVERYTHING)
    assert len(file.imports) == 2
    assert [type(d).__name__ for d in file.declarations] == (
        "Value Function Function Domain Domain Model Model Model Scene".split()
    )


@pytest.mark.parametrize("path", sorted(ROOT.glob("library/**/*.bg")), ids=lambda path: path.stem)
def test_library_is_read(path: Path) -> None:
    _, found = parse(read_source(path))
    assert not found, render(found, colour=False)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("-2^2", "(-(2^2))"),
        ("2^-1", "(2^(-1))"),
        ("2^3^2", "(2^(3^2))"),
        ("a - b - c", "((a-b)-c)"),
        ("a/b*c", "((a/b)*c)"),
        ("-a*b", "((-a)*b)"),
        ("a + b*c^d", "(a+(b*(c^d)))"),
        ("not a < b and c or d", "(((not(a<b))andc)ord)"),
        ("A[1, 2..3].x", "A[1,2..3].x"),
        ("cross(a, b).z", "cross(a,b).z"),
        ("der(x)", "der(x)"),
        ("time", "time"),
        ("3 m * l", "(3_m*l)"),
        ("2 kg*m/s", "2_kg*m/s"),
        ("2 kg*m/s - 3 N", "(2_kg*m/s-3_N)"),
        ("10 s^-1", "10_s^-1"),
        ("1 Pa^0.5", "1_Pa^0.5"),
        (".5", "1/2"),
        ("1e5", "100000"),
        ("1.5e-3 m", "3/2000_m"),
        ("10/s", "(10/s)"),
        ("10 / s", "(10/s)"),
        ("x[1..3]", "x[1..3]"),
        ("x[a..b + 1]", "x[a..(b+1)]"),
    ],
)
def test_expression(text: str, shown: str) -> None:
    assert show(expression(text)) == shown


def test_numbers_are_exact() -> None:
    value = expression("0.1")
    assert isinstance(value, Number)
    assert value.value == Fraction(1, 10)


def test_words_after_a_number_are_no_units() -> None:
    (item,) = items("param k = 1 in 0 .. 5;")
    assert isinstance(item, syntax.Value)
    assert isinstance(item.value, Number)
    assert item.value.unit is None
    assert item.range is not None
    expression("if a > 1 then 2 else 3 m")


def test_element_letters_are_plain_names() -> None:
    part = items("param C = 10 uF; capacitor : C(C);")[1]
    assert isinstance(part, syntax.Part)
    assert part.type.name == "C"
    items("R : R(R); I : I(e); e -> f -> R; let H = e1*f2 + p + q;")


def test_scene_words_are_names_in_a_model() -> None:
    words = "observe run solver device drive require deadline step keep of is out main as every"
    for word in words.split():
        items(f"{word} : R(2); a -> {word}; let y = {word}.e + 1;")


def test_slot_and_type_use() -> None:
    (slot,) = items("lock : Lock[5] = Compliant[5](k = 1);")
    assert isinstance(slot, syntax.Part)
    assert slot.default is not None
    assert slot.default.name == "Compliant"
    (joint,) = items("j : Joint(lock = Rigid[5](k = 1), a = Rigid(k = 1), b = Rigid[5], c = f(1));")
    assert isinstance(joint, syntax.Part)
    values = [argument.value for argument in joint.type.arguments]
    assert [type(value) for value in values] == [TypeUse, TypeUse, Index, Call]


def test_law_block_may_end_with_a_semicolon() -> None:
    for end in ("", ";"):
        part, port = items(f"r : R {{ e = f; }}{end} port p;")
        assert isinstance(part, syntax.Part)
        assert part.law is not None
        assert isinstance(port, syntax.Port)


def test_chain_keeps_its_lists() -> None:
    (chain,) = items("a, b -> c -> d, e, f;")
    assert isinstance(chain, syntax.Chain)
    assert [len(stop) for stop in chain.stops] == [2, 1, 3]


def test_else_if_nests() -> None:
    (outer,) = items("if a { x -> y; } else if b { } else { y -> x; }")
    assert isinstance(outer, syntax.If)
    (inner,) = outer.no
    assert isinstance(inner, syntax.If)
    assert len(inner.no) == 1


def test_docs_belong_to_what_they_stand_above() -> None:
    text = (
        "/// One.\n///  Two.\n\nmodel A {\n  /// x\n  param k = 1; param l = 2;  /// y\n  port p; }"
    )
    (model,) = read(text).declarations
    assert isinstance(model, syntax.Model)
    assert model.doc == "One.\n Two."
    assert [item.doc for item in model.items] == ["x", "", ""]  # type: ignore[union-attr]


def test_spans_cover_what_was_read() -> None:
    (part,) = items("boom : I[6](mass*(a + b));")
    assert isinstance(part, syntax.Part)
    assert part.span.text == "boom : I[6](mass*(a + b))"
    assert part.name_span.text == "boom"
    assert part.type.arguments[0].value.span.text == "mass*(a + b)"


# --- what is refused --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "underlined", "spelling"),
    [
        ("5V", "5V", "`5 V`"),
        ("2x", "2x", "`2*x`"),
        ("1.", "1.", "`1`"),
        ("1.x", "1.", "`1.0`"),
        ("1.2.3", "1.2.", ""),
        ("3 kN.m", "3 kN.m", "`3 kN*m`"),
        ("10 /s", "10 /s", "`10 s^-1`"),
        ("2 kg *m", "2 kg *m", "`2 kg*m`"),
        ("3  m", "3  m", "`3 m`"),
        ("3 kg m", "3 kg m", "`3 kg*m`"),
    ],
)
def test_misspelt_number_prints_the_right_spelling(
    text: str, underlined: str, spelling: str
) -> None:
    _, found = parse(Source("test.bg", f"model M {{ let y = {text}; }}"))
    assert [d.code for d in found] == ["BG106"]
    assert found[0].span is not None
    assert found[0].span.text == underlined
    assert spelling in found[0].help


@pytest.mark.parametrize("word", sorted(RESERVED))
def test_reserved_word_is_no_name(word: str) -> None:
    assert wrong_in_model(f"param {word};") == [("BG112", word)]
    assert wrong_in_model(f"a -> {word};") == [("BG112", word)]
    if word != "time":  # which may be a column of data
        assert wrong_in_model(f"let y = a.{word};") == [("BG112", word)]


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("param = 2 ohm;", [("BG101", "=")]),
        ("param R = 2 ohm param L = 3;", [("BG102", "")]),
        ("a : I(2)\n b : C(3)", [("BG102", ""), ("BG102", "")]),
        ("coil : I(3; x : C(2);", [("BG103", ";")]),
        ("let y = (a + b];", [("BG103", "]")]),
        ("let y = [1, 2);", [("BG103", ")")]),
        ("a : R(2));", [("BG104", ")")]),
        ("let y = 3 ω;", [("BG107", "ω")]),
        ("let ω = 3;", [("BG107", "ω")]),
        ("let y = a ** b;", [("BG108", "**")]),
        ("let y = a && b;", [("BG108", "&&")]),
        ("let y == 3;", [("BG108", "==")]),
        ("let y = J'*F;", [("BG109", "'")]),
        ('assert a > 1, "far;', [("BG111", '"far; }')]),
        ("let y = 0 < x < 1;", [("BG113", "<")]),
        ("let y = a b;", [("BG114", "b")]),
        ("if n = 3 { }", [("BG115", "=")]),
        ("run 10 s;", [("BG116", "run")]),
        ("observe x;", [("BG116", "observe")]),
        ("set a.b = 3;", [("BG116", "set")]),
        ("function f(x) = x;", [("BG116", "function")]),
        ("parm R = 2;", [("BG117", "parm")]),
        ("let y = 1e999;", [("BG119", "1e999")]),
        ("a.b : R(2);", [("BG123", "a.b")]),
        ("s : A = B { e = f; }", [("BG124", "{ e = f; }")]),
        ("a -> b, c -> d;", [("BG125", "b, c")]),
        ("let v = [];", [("BG126", "[]")]),
        ("let y = 2(a + b);", [("BG127", "2")]),
        ("let y = a.b(3);", [("BG127", "a.b")]),
        ("der x = 3;", [("BG128", "der")]),
        ("let y = der(a, b);", [("BG128", "der")]),
        ("let y = der[[1, 2]];", [("BG128", "der")]),
        ("let y = der(a)(b);", [("BG128", "der")]),
        ("m[1..3] : I(2);", [("BG130", "1..3")]),
        ("a : R(2);;", [("BG131", ";")]),
        ("let y = time[1];", [("BG132", "[1]")]),
        ("a -> ;", [("BG101", ";")]),
        ("let y = 3 +;", [("BG101", ";")]),
        ("port p up;", [("BG101", "up")]),
        ("param x : 3;", [("BG101", "3")]),
    ],
)
def test_wrong_item(body: str, expected: list[tuple[str, str]]) -> None:
    assert wrong_in_model(body) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("model A { } }", [("BG104", "}")]),
        ("model A { param k = 1;", [("BG105", "")]),
        ("model A { param k = 1;\nmodel B { }", [("BG105", "model")]),
        ("/* no end", [("BG110", "/*")]),
        ("scene s of A { device run = trace; }", [("BG112", "run")]),
        ("scene s of A { observe x as step; }", [("BG112", "step")]),
        ("scene s of A { param k = 3; }", [("BG116", "param")]),
        ("scene s of A { obsrve x; }", [("BG117", "obsrve")]),
        ("let k = 3;", [("BG116", "let")]),
        ("modl A { param k = 1; }", [("BG117", "modl")]),
        ("model A { } import b;", [("BG122", "import b")]),
        ("function f(x, k = 2) = k*x;", [("BG129", "k = 2")]),
        ("model A { };", [("BG131", ";")]),
        ("domain D { param k = 1; }", [("BG116", "param")]),
        ("model A is { }", [("BG101", "{")]),
        ("model", [("BG101", "")]),
        ("# model", [("BG108", "#")]),
        ("\0", [("BG107", "\0")]),
    ],
)
def test_wrong_file(text: str, expected: list[tuple[str, str]]) -> None:
    assert wrong(text) == expected


def test_one_run_reports_many_errors() -> None:
    body = "let a = 5V;\n b : I(2\n c : R(3);\n let d = x x;\n for i in 1..3 { let e = ; }\n g ->"
    codes = [code for code, _ in wrong_in_model(body)]
    assert codes == ["BG106", "BG103", "BG114", "BG101", "BG101"]


def test_reading_goes_on_after_an_error() -> None:
    file, found = parse(
        Source(
            "test.bg", "model A { let a = 5V; b : I(2); }\n@\nmodel B { } scene s of B { run ; }"
        )
    )
    assert [d.code for d in found] == ["BG106", "BG107", "BG101"]
    names = [d.name for d in file.declarations]
    assert names == ["A", "B", "s"]
    model = file.declarations[0]
    assert isinstance(model, syntax.Model)
    assert len(model.items) == 1


def test_number_of_errors_is_bounded() -> None:
    found = wrong_in_model("x y z;\n" * 1000)
    assert len(found) == MAX_ERRORS + 1
    assert found[-1][0] == "BG121"
    assert wrong("model A { }\n" + "import a;\n" * 1000)[-1][0] == "BG121"


@pytest.mark.parametrize(
    "text",
    [
        "a" * 10_000_000,
        "model A { let x = " + "1+" * 5_000_000 + "1; }",
        "model A { let x = " + "(\n" * 5000,
        "model A { let x = " + "[" * 5000,
        "model A { let x = " + "-" * 5000 + "1; }",
        "model A { let x = " + "not " * 5000 + "1; }",
        "model A { let x = " + "2^" * 5000 + "1; }",
        "model A { let x = " + "sin(" * 5000,
        "model A { let x = a" + ".b" * 5000 + "; }",
        "model A { let x = " + "if a then b else " * 5000 + "1; }",
        "model A { " + "if a { } else " * 5000 + "{ } }",
        "model A { " + "for i in 1..2 { " * 5000 + "}" * 5000,
        "model A { let x = " + "1" * 5000 + "; }",
        "{" * 50_000,
        "}" * 50_000,
        "{;}" * 20_000,
        '"' * 50_001,
        "/*" + "*" * 50_000,
        "\x00" * 1000,
        "\ufeff",
        "model \udc80 { }",
    ],
    ids=lambda text: repr(text[:30]),
)
def test_absurd_text_gets_a_diagnostic(text: str) -> None:
    assert wrong(text)


@pytest.mark.parametrize(
    "text", ["", "\n", "// only a comment", "model A { let x = " + "1\n+ " * 5000 + "1; }"]
)
def test_unusual_text_is_read(text: str) -> None:
    read(text)


def mutated(text: str, rng: random.Random) -> str:
    """A part of a text with a few of its characters removed, doubled, moved or replaced."""
    start = rng.randrange(len(text))
    text = text[start : start + 2000] if rng.random() < 0.3 else text
    odd = [
        *"{}()[];:,.=<'\"^@\0\\\r\t",
        "->",
        "..",
        "/*",
        "*/",
        "///",
        "\ufeff",
        "5V",
        "1.",
        "10 /s",
    ]
    odd += [*sorted(RESERVED), "é", "1e999", "\ud800"]
    for _ in range(rng.choice([1, 1, 2, 5])):
        at = rng.randrange(len(text) + 1)
        end = min(len(text), at + rng.choice([0, 1, 2, 30]))
        change = rng.choice(["insert", "remove", "double", "reverse"])
        if change == "insert":
            text = text[:at] + rng.choice(odd) + text[end:]
        elif change == "remove":
            text = text[:at] + text[end:]
        elif change == "double":
            text = text[:end] + text[at:]
        else:
            text = text[:at] + text[at:end][::-1] + text[end:]
    return text


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(200))
def test_mutated_text_never_breaks_the_parser(seed: int) -> None:
    rng = random.Random(seed)
    text = mutated(EVERYTHING, rng)
    source = Source("test.bg", text)
    _, found = parse(source)
    assert len(found) <= MAX_ERRORS + 1
    assert render(found, colour=True) or not found
    for diagnostic in found:
        assert isinstance(diagnostic.span, Span)
        assert 0 <= diagnostic.span.start <= diagnostic.span.end <= len(text)
        own_words = re.sub(r"`[^`]*`|U\+\w+", "", diagnostic.message)
        assert not re.search(r"[A-Z]{2}|__|\$", own_words), diagnostic.message


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100))
def test_mixed_up_tokens_never_break_the_parser(seed: int) -> None:
    rng = random.Random(seed)
    _, tokens, _ = parse_with_tokens(Source("test.bg", EVERYTHING))
    words = [str(token) for token in tokens]
    start = rng.randrange(len(words))
    mixed = words[start : start + rng.choice([30, 300])]
    for _ in range(rng.choice([1, 2, 4])):
        mixed[rng.randrange(len(mixed))] = rng.choice(words)
        mixed.insert(rng.randrange(len(mixed)), rng.choice(words))
    text = "model A { " + " ".join(mixed)
    assert wrong(text)


def test_every_kind_of_block_has_a_form_for_messages():
    """A statement that no block knows is explained by the form of its block."""
    assert set(WORDS) | set(BLOCK_OF.values()) <= set(FORMS_IN)
