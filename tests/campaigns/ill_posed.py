"""Generators of ill-posed models: each draws sizes, numbers and surroundings of one kind of fault.

A generator returns the items of a model that has no answer, or many, or none beyond some time.
`drafted` puts them into random surroundings: alone, beside sound parts, in a part of a part, or in
an array. `bgc` has to refuse the model or to end its run with a code; numbers alone are wrong.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias


@dataclass(frozen=True, slots=True)
class Core:
    """A fault: items of a model, names to observe in it, declarations and scene statements.

    In `scene`, `{at}` stands for the path of the items in the scene's model. `warns` marks models
    that run, and of which a warning is the right answer.
    """

    items: str
    observe: tuple[str, ...] = ()
    scene: str = ""
    declarations: str = ""
    run: str = "run 2 s every 0.1 s;"
    warns: bool = False
    whole_scene: bool = True


SOLVERS = (
    *("", "", "solver rodas5p;", "solver dopri5;", "solver radau5;", "solver tsit5;"),
    *(
        "step 1 ms;",
        "solver ros34prw; step 1 ms;",
        "solver rk4; step 1 ms;",
        "solver lie; step 1 ms;",
    ),
)

Generator: TypeAlias = Callable[[random.Random], Core]


def number(rng: random.Random, low: float = 0.1, high: float = 50.0) -> str:
    """A positive number, written with one to four digits, or with an exponent."""
    value = low * (high / low) ** rng.random()
    return rng.choice((f"{value:.1g}", f"{value:.2g}", f"{value:.4g}", f"{value:.3e}"))


def whole(rng: random.Random, low: int = 2, high: int = 5) -> int:
    return rng.randint(low, high)


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


def drafted(rng: random.Random, core: Core) -> str:
    """Put an ill-posed core into surroundings that have an answer."""
    beside = " ".join(_sound(rng, f"sound{k}_") for k in range(rng.choice((0, 0, 1, 2))))
    how = rng.choice(("alone", "beside", "part", "nested", "array"))
    if how in ("alone", "beside") or not core.observe:
        at, text = "", f"model M {{ {core.items} {beside if how == 'beside' else ''} }}"
    else:
        count = whole(rng, 2, 3)
        text = f"model Inner {{ {core.items} }}"
        if how == "part":
            at, body = "core.", "core : Inner;"
        elif how == "nested":
            text += "model Middle { inner : Inner; }"
            at, body = "middle.inner.", "middle : Middle;"
        else:
            at, body = f"core[{count}].", f"for i in 1..{count} {{ core[i] : Inner; }}"
        text += f"model M {{ {body} {beside} }}"
    names = ", ".join(f"{at}{name}" for name in core.observe)
    observed = f"observe {names};" if names else ""
    scene = f"scene trial of M {{ {observed} {core.scene.replace('{at}', at)} {core.run} }}"
    return f"{core.declarations} {text} {scene if core.whole_scene else ''}".replace("; ", ";\n")
