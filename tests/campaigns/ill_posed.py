"""Ill-posed models: kinds of faults in `ill_posed.txt`, each drawn with other numbers and sizes.

`drafted` puts a fault into random surroundings: alone, beside sound parts, in a part of a part, or
in an array. `bgc` has to refuse the model or to end its run with a code; numbers alone are wrong.
"""

from __future__ import annotations

import random
import re
from pathlib import Path

from judging import Verdict, judged, run_briefly

PORTION = 500
RUN_SECONDS = 20.0  # of processor time

_ALTERNATIVES = re.compile(r"<<((?:(?!<<|>>).)*)>>", re.DOTALL)
_REPEATED = re.compile(r"\[\*n: (.*?)\*\]", re.DOTALL)
_NUMBER = re.compile(r"#([a-z]?)(?:\(([\d.]+), ([\d.]+)\)|\[(\d+)\.\.(\d+)\])?")
_FIELD = re.compile(r"^(observe|scene|run|declares|count|warns|no scene):? ?(.*)$")


def _kinds() -> dict[str, str]:
    """The kinds of faults by name, in the order of the numbers of their cases."""
    text = Path(__file__).with_suffix(".txt").read_text(encoding="utf-8")
    text = re.sub(r"^//.*\n", "", text, flags=re.MULTILINE)
    _, *kinds = text.split("### ")
    return {name: body for name, _, body in (kind.partition("\n") for kind in kinds)}


KINDS = _kinds()


def number(rng: random.Random, low: float = 0.1, high: float = 50.0) -> str:
    """A positive number, written with one to four digits, or with an exponent."""
    value = low * (high / low) ** rng.random()
    return rng.choice((f"{value:.1g}", f"{value:.2g}", f"{value:.4g}", f"{value:.3e}"))


def _drawn(rng: random.Random, text: str) -> str:
    """The text of a kind with alternatives chosen, parts repeated and numbers put in."""
    while _ALTERNATIVES.search(text):
        text = _ALTERNATIVES.sub(lambda found: rng.choice(found[1].split("|")).strip(" "), text)
    if ranged := re.search(r"^count: n = (\d)\.\.(\d)$", text, re.MULTILINE):
        n = rng.randint(int(ranged[1]), int(ranged[2]))
        text = _REPEATED.sub(
            lambda found: "".join(
                found[1].replace("@+", str((k + 1) % n)).replace("@", str(k)) for k in range(n)
            ),
            text,
        )
    named: dict[str, str] = {}

    def value(found: re.Match[str]) -> str:
        if found[1] in named:
            return named[found[1]]
        if found[4]:
            drawn = str(rng.randint(int(found[4]), int(found[5])))
        else:
            drawn = number(rng, float(found[2] or 0.1), float(found[3] or 50.0))
        if found[1]:
            named[found[1]] = drawn
        return drawn

    return _NUMBER.sub(value, text)


def _sound(rng: random.Random, name: str) -> str:
    """A part with an answer: an oscillator, a circuit, or an equation."""
    a, b, c = (number(rng) for _ in range(3))
    return rng.choice(
        (
            f"{name}j : J1; {name}m : I({a}); {name}k : C(stiffness = {b}, q0 = 1); "
            f"{name}d : R({c}); {name}j -> {name}m, {name}k, {name}d;",
            f"{name}s : Se(e = {a}); {name}j : J1; {name}c : C({b}); {name}r : R({c}); "
            f"{name}s -> {name}j -> {name}c, {name}r;",
            f"state {name}x = {a}; der({name}x) = -{b}*{name}x + sin({c}*time);",
            f"state {name}x = 1; unknown {name}y = 0; der({name}x) = -{name}y; "
            f"equation {name}y + {name}y^3 = {b}*{name}x;",
        )
    )


def drafted(rng: random.Random, kind: str) -> tuple[str, bool]:
    """An ill-posed model in surroundings that have an answer; whether a warning will do."""
    fields = {"run": "run 2 s every 0.1 s;"}
    items = []
    for line in _drawn(rng, KINDS[kind]).splitlines():
        if field := _FIELD.match(line):
            fields[field[1]] = field[2]
        else:
            items.append(line)
    core, names = "\n".join(items), fields.get("observe", "")
    beside = " ".join(_sound(rng, f"sound{k}_") for k in range(rng.choice((0, 0, 1, 2))))
    how = rng.choice(("alone", "beside", "part", "nested", "array"))
    if how in ("alone", "beside") or not names:
        at, text = "", f"model M {{ {core} {beside if how == 'beside' else ''} }}"
    else:
        count = rng.randint(2, 3)
        at, body, inner = {
            "part": ("core.", "core : Inner;", ""),
            "nested": ("middle.inner.", "middle : Middle;", "model Middle { inner : Inner; }"),
            "array": (f"core[{count}].", f"for i in 1..{count} {{ core[i] : Inner; }}", ""),
        }[how]
        text = f"model Inner {{ {core} }} {inner} model M {{ {body} {beside} }}"
    observed = ", ".join(f"{at}{name}" for name in names.split(", ")) if names else ""
    statements = [f"observe {observed};" if names else "", fields.get("scene", ""), fields["run"]]
    scene = f"scene trial of M {{ {' '.join(statements).replace('{at}', at)} }}"
    text = f"{fields.get('declares', '')} {text} {'' if 'no scene' in fields else scene}"
    return text.replace("; ", ";\n"), "warns" in fields


def _case(seed: int, number: int) -> tuple[str, str, bool]:
    kind = list(KINDS)[number % len(KINDS)]
    return kind, *drafted(random.Random(f"{seed}:{number}"), kind)


def text_of(seed: int, number: int) -> tuple[str, bytes]:
    """The kind of a case, and its text; the kinds follow each other in turn."""
    kind, text, _ = _case(seed, number)
    return kind, text.encode()


def judge(seed: int, number: int, folder: Path) -> list[Verdict]:
    """`refused` by the compiler, `stopped` in its run, `warned` where that will do, or a fault."""
    kind, text, warns = _case(seed, number)
    path = folder / "ill_posed.bg"
    path.write_text(text, "utf-8")
    verdict = judged(path, verify=True)
    if verdict.outcome in ("accepted", "parts only"):
        verdict = run_briefly(path, RUN_SECONDS)
    if verdict.outcome in ("ran", "slow", "accepted", "parts only"):
        if warns and verdict.codes:
            return [Verdict("warned", verdict.codes)]
        return [Verdict("silent", verdict.codes, f"{kind}: {verdict.outcome}")]
    return [verdict]
