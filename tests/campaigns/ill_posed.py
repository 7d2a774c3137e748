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
GENERATORS: dict[str, Generator] = {}


def generator(make: Generator) -> Generator:
    GENERATORS[make.__name__] = make
    return make


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


# --- junctions and sources --------------------------------------------------------------


@generator
def efforts_that_differ(rng):
    n = whole(rng, 2, 4)
    sources = "".join(f"s{k} : Se(e = {number(rng)}); s{k} -> j; " for k in range(n))
    return Core(f"j : J0; r : R({number(rng)}); j -> r; {sources}", ("r.f", "s0.f"))


@generator
def flows_that_differ(rng):
    n = whole(rng, 2, 4)
    sources = "".join(f"s{k} : Sf(f = {number(rng)}); s{k} -> j; " for k in range(n))
    return Core(f"j : J1; r : I({number(rng)}); j -> r; {sources}", ("r.p", "s0.e"))


@generator
def sources_in_conflict_through_gears(rng):
    n = whole(rng, 1, 4)
    chain = " -> ".join(f"t{k} -> k{k}" for k in range(n))
    parts = "".join(f"t{k} : TF({number(rng)}); k{k} : J1; " for k in range(n))
    return Core(
        f"a : Sf(f = {number(rng)}); j : J1; b : Sf(f = {number(rng)}); m : I({number(rng)});"
        f"{parts} a -> j -> {chain} -> b; j -> m;",
        ("m.p", "a.e"),
    )


@generator
def sources_in_conflict_through_a_gyrator(rng):
    return Core(
        f"a : Se(e = {number(rng)}); j : J1; g : GY({number(rng)}); k : J1; "
        f"b : Sf(f = {number(rng)}); c : C({number(rng)}); l : J0; l2 : J0; "
        f"a -> l -> g -> k; b -> k; l -> c;",
        ("c.q", "b.e"),
    )


@generator
def equal_efforts_in_parallel(rng):
    e = number(rng)
    return Core(f"a : Se(e = {e}); b : Se(e = {e}); j : J0; a -> j -> b;", ("a.f",))


@generator
def a_junction_of_sources_alone(rng):
    kind = rng.choice(("Se", "Sf"))
    junction = "J1" if kind == "Se" else "J0"
    n = whole(rng)
    sources = "".join(f"s{k} : {kind}({number(rng)}); s{k} -> j; " for k in range(n))
    return Core(f"j : {junction}; {sources}", ("s0.power", f"j.{'f' if kind == 'Se' else 'e'}"))


@generator
def a_ring_of_transformers(rng):
    """The flow circulates: with a product of ratios of 1 any flow is an answer."""
    n = whole(rng, 2, 4)
    ratios = [rng.choice((2, 4, 5, 8, 10)) for _ in range(n - 1)]
    last = 1.0
    for ratio in ratios:
        last /= ratio
    values = [*map(str, ratios), repr(last)]
    parts = "".join(f"j{k} : J1; t{k} : TF({values[k]}); " for k in range(n))
    bonds = "".join(f"j{k} -> t{k} -> j{(k + 1) % n}; " for k in range(n))
    return Core(parts + bonds + f"s : Se({number(rng)}); s -> j0;", ("j0.f",))


@generator
def a_ring_of_junctions(rng):
    n, kind = whole(rng, 3, 5), rng.choice(("J0", "J1"))
    source = f"Sf({number(rng)})" if kind == "J0" else f"Se({number(rng)})"
    parts = "".join(f"j{k} : {kind}; " for k in range(n))
    bonds = "".join(f"j{k} -> j{(k + 1) % n}; " for k in range(n))
    return Core(f"{parts}{bonds} s : {source}; s -> j0;", (f"j0.{'e' if kind == 'J0' else 'f'}",))


@generator
def a_ring_of_gyrators_between_sources(rng):
    a, b = number(rng), number(rng)
    return Core(
        f"a : Se({a}); j : J1; g : GY({b}); k : J1; h : GY({b}); l : J0; r : Se({a});"
        "a -> j -> g -> k -> h -> l; r -> l;",
        ("j.f",),
    )


@generator
def parts_without_bonds(rng):
    kind = rng.choice((f"R({number(rng)})", "J1", f"C({number(rng)})", "TF(2)", "Se(1)", "GY(1)"))
    return Core(f"x : {kind}; j : J1; m : I(1); r : R(1); j -> m, r;", ("m.f",))


@generator
def arrows_out_of_passive_parts(rng):
    kind = rng.choice((f"R({number(rng)})", f"C({number(rng)})", f"I({number(rng)})"))
    return Core(f"x : {kind}; j : J1; m : I(1); x -> j -> m;", ("m.f",))


@generator
def a_closed_chain_held_twice(rng):
    """A bead on a curve, held by two constraints that agree at the start only."""
    b, c, m = number(rng), number(rng), number(rng)
    return Core(
        "state x = 0.6; state y = 0.8; der(x) = along.f; der(y) = across.f;"
        "signal gap = (x^2 + y^2 - 1)/2; project gap = 0; along : J1; across : J1;"
        f"mx : I({m}); my : I({c}); left : MTF {{ f2 = x*f1; }} right : MTF {{ f2 = y*f1; }}"
        "meet : J0; hold : Sf(f = 0); along -> mx; across -> my; along -> left -> meet;"
        "across -> right -> meet; meet -> hold;"
        f"left2 : MTF {{ f2 = x*(1 + {b}*gap)*f1; }} right2 : MTF {{ f2 = y*(1 - {c}*gap)*f1; }}"
        "meet2 : J0; hold2 : Sf(f = 0); along -> left2 -> meet2; across -> right2 -> meet2;"
        "meet2 -> hold2;",
        ("x", "y"),
        warns=True,
    )


@generator
def a_closed_chain_without_freedom(rng):
    """A point held on two circles, which meet in points: no motion is left."""
    w = number(rng)
    return Core(
        "state x = 0.6; state y = 0.8; der(x) = along.f; der(y) = across.f;"
        "signal gap = (x^2 + y^2 - 1)/2; signal gap2 = ((x - 1.2)^2 + y^2 - 1)/2;"
        "project gap = 0; project gap2 = 0; along : J1; across : J1; push : Se(e = "
        f"{w}); push -> along; mx : I(1); my : I({w}); along -> mx; across -> my;"
        "a : MTF { f2 = x*f1; } b : MTF { f2 = y*f1; } meet : J0; hold : Sf(f = 0.1);"
        "along -> a -> meet; across -> b -> meet; meet -> hold;"
        "c : MTF { f2 = (x - 1.2)*f1; } d : MTF { f2 = y*f1; } meet2 : J0; hold2 : Sf(f = 0);"
        "along -> c -> meet2; across -> d -> meet2; meet2 -> hold2;",
        ("x", "y"),
    )


@generator
def a_closed_chain_that_starts_open(rng):
    x, y = number(rng, 0.2, 3), number(rng, 1.2, 3)
    return Core(
        f"state x = {x}; state y = {y}; der(x) = along.f; der(y) = across.f;"
        "signal gap = (x^2 + y^2 - 1)/2; project gap = 0; along : J1; across : J1;"
        "mx : I(1); my : I(2); left : MTF { f2 = x*f1; } right : MTF { f2 = y*f1; }"
        "meet : J0; hold : Sf(f = 0); along -> mx; across -> my; along -> left -> meet;"
        "across -> right -> meet; meet -> hold;",
        ("x", "y"),
    )


# --- ratios and parameters of elements --------------------------------------------------


@generator
def a_ratio_of_zero(rng):
    """The wheel would have to turn while its shaft stands still."""
    zero = rng.choice(("0", "0.0", "1 - 1", "p - p", "0*p", "p*0"))
    return Core(
        f"param p = {number(rng)}; s : Sf({number(rng)}); j : J1; t : TF({zero});"
        f"k : J1; m : I({number(rng)}); k -> m; k -> t -> j; s -> j;",
        ("m.p",),
    )


@generator
def a_ratio_that_becomes_zero(rng):
    t0 = number(rng, 0.3, 1.5)
    return Core(
        f"s : Sf({number(rng)}); k : J1; m : I({number(rng)}); t : MTF {{ f2 = (time - {t0})*f1; }}"
        "k -> m; k -> t -> j; j : J1; s -> j;",
        ("m.p", "k.f"),
    )


@generator
def storage_of_zero(rng):
    zero = rng.choice(("0", "0.0", "p - p", "1/3 - 1/3", "0*p"))
    kind = rng.choice(("I", "C"))
    return Core(
        f"param p = {number(rng)}; s : Se({number(rng)}); j : J1; x : {kind}({zero}); "
        f"r : R({number(rng)}); s -> j -> x, r;",
        ("r.f",),
    )


@generator
def storage_set_to_zero(rng):
    kind = rng.choice(("I", "C"))
    return Core(
        f"param p = {number(rng)}; s : Se({number(rng)}); j : J1; x : {kind}(p); "
        f"r : R({number(rng)}); s -> j -> x, r;",
        ("r.f",),
        "set {at}p = 0;",
    )


@generator
def negative_storage(rng):
    kind = rng.choice(("I", "C"))
    negative = rng.choice((f"-{number(rng)}", f"1 - {whole(rng, 2, 9)}", "-p"))
    return Core(
        f"param p = {number(rng)}; s : Se({number(rng)}); j : J1; x : {kind}({negative}); "
        f"r : R({number(rng)}); s -> j -> x, r;",
        ("r.f",),
        warns=True,
    )


@generator
def inertias_that_cancel(rng):
    m = number(rng)
    return Core(
        f"param m = {m}; s : Se({number(rng)}); j : J1; a : I(m); b : I(-m); r : R(1);"
        "s -> j -> a, b, r;",
        ("r.f",),
    )


@generator
def compliances_that_cancel(rng):
    c = number(rng)
    return Core(
        f"s : Sf({number(rng)}); j : J0; a : C({c}); b : C(-{c}); r : R(1); s -> j -> a, b, r;",
        ("r.e",),
    )


@generator
def matrices_of_storage_that_are_singular(rng):
    a = number(rng)
    matrix = rng.choice(
        (
            f"[[{a}, {a}], [{a}, {a}]]",
            f"[[{a}, 0], [0, 0]]",
            "[[1, 2], [2, 4]]",
            f"diag([0, {a}])",
            "zeros(2, 2)",
        )
    )
    kind = rng.choice(("I", "C"))
    return Core(
        f"s : Se[2](e = [1, {a}]); j : J1[2]; x : {kind}[2]({matrix}); r : R[2]({a});"
        "s -> j -> x, r;",
        ("r.f",),
    )


@generator
def a_resistance_of_zero_across_a_source(rng):
    zero = rng.choice(("0", "p - p", "0*p"))
    return Core(
        f"param p = {number(rng)}; s : Se({number(rng)}); j : J0; r : R({zero}); s -> j -> r;",
        ("r.f",),
    )


@generator
def a_resistance_set_to_zero(rng):
    return Core(
        f"param p = {number(rng)}; s : Se({number(rng)}); j : J0; r : R(p); s -> j -> r;",
        ("r.f",),
        "set {at}p = 0;",
    )


@generator
def a_resistance_matrix_without_inverse(rng):
    a = number(rng)
    return Core(
        f"s : Se[2](e = [1, {a}]); j : J0[2]; r : R[2]([[{a}, {a}], [{a}, {a}]]); s -> j -> r;",
        ("r.f",),
    )


@generator
def resistances_that_cancel(rng):
    r = number(rng)
    return Core(
        f"s : Se({number(rng)}); j : J1; a : R({r}); b : R(-{r}); s -> j -> a, b;", ("a.f",)
    )


@generator
def feedback_that_cancels_a_resistance(rng):
    r = number(rng)
    return Core(
        f"param k = {r}; s : Se(e = {number(rng)} + k*r.f); j : J1; r : R({r}); s -> j -> r;",
        ("r.f",),
    )


# --- values -----------------------------------------------------------------------------


@generator
def divisions_by_zero(rng):
    zero = rng.choice(("0", "(q - q)", "(1 - 1)", "sin(0)", "(2*q - q - q)", "0^2", "min(0, q)"))
    return Core(
        f"param q = {number(rng)}; param p = {number(rng)}/{zero}; state x = 1; der(x) = -x*p;",
        ("x",),
    )


@generator
def divisions_by_a_parameter_set_to_zero(rng):
    return Core(
        f"param q = {number(rng)}; state x = 1; der(x) = -x/q; let y = {number(rng)}/q;",
        ("x", "y"),
        "set {at}q = 0;",
    )


@generator
def values_outside_of_a_function(rng):
    bad = rng.choice(
        (
            f"sqrt(-{number(rng)})",
            f"log(-{number(rng)})",
            "log(0)",
            f"asin(1 + {number(rng)})",
            f"acos(-1 - {number(rng)})",
            f"(-{number(rng)})^0.5",
            f"0^(-{whole(rng)})",
            "inverse([[1, 2], [2, 4]])[1, 1]",
            "exp(1000)",
            "10^400",
            "log(1 - 1)",
        )
    )
    kind = rng.choice(("param", "let", "const"))
    return Core(f"{kind} p = {bad}; state x = 1; der(x) = -x*p;", ("x",))


@generator
def values_in_a_circle(rng):
    n, kind = whole(rng, 1, 6), rng.choice(("param", "let", "const", "signal"))
    text = " ".join(f"{kind} a{k} = a{(k + 1) % n}*{number(rng)} + 1;" for k in range(n))
    return Core(f"{text} state x = 1; der(x) = -x*a0;", ("x",))


@generator
def functions_in_a_circle(rng):
    n = whole(rng, 1, 5)
    text = " ".join(f"function f{k}(x) = f{(k + 1) % n}(x) + 1;" for k in range(n))
    return Core("state x = 1; der(x) = -f0(x);", ("x",), declarations=text)


@generator
def models_in_a_circle(rng):
    n, twice = whole(rng, 1, 4), whole(rng, 1, 3)
    text = " ".join(
        f"model A{k} {{ {' '.join(f'p{i} : A{(k + 1) % n};' for i in range(twice))} }}"
        for k in range(n)
    )
    return Core("state x = 1; der(x) = -x; deep : A0;", ("x",), declarations=text)


@generator
def names_that_nothing_declares(rng):
    item, scene = rng.choice(
        (
            ("let y = z*2;", ""),
            ("r : R(k); j : J1; m : I(1); j -> r, m;", ""),
            ("j : J1; m : I(1); j -> m, other;", ""),
            ("r : Unknown(2);", ""),
            ("", "set {at}nothing = 3;"),
            ("", "drive {at}nothing = 3;"),
            ("", "observe {at}nothing;"),
            ("", "keep {at}nothing;"),
            ("", "use {at}nothing = R(1);"),
            ("v : J1[2]; m : I[2](1); v -> m; let y = v.f[3];", ""),
            ("", "solver nothing;"),
            ("", "plot {at}nothing;"),
            ("let y = x.q;", ""),
            ("let y = sine(x);", ""),
        )
    )
    return Core(f"state x = 1; der(x) = -{number(rng)}*x; {item}", ("x",), scene)


@generator
def slots_without_a_part(rng):
    n = whole(rng, 1, 3)
    parts = " ".join(f"s{k} : Any;" for k in range(n))
    return Core(
        f"state x = 1; der(x) = -x; {parts}",
        ("x",),
        declarations="interface Any { output y; }",
    )


@generator
def units_in_conflict(rng):
    n = number(rng)
    item = rng.choice(
        (
            f"let y = {n} m + {n} kg;",
            f"param p : kg = {n} N;",
            f"let y = exp({n} m);",
            f"let y = if {n} m > {n} s then 1 else 0;",
            f"j : J1; m : I({n} kg); k : C(stiffness = {n} N*s/m); j -> m, k;",
            f"let y = sqrt({n} m) + {n} m;",
            f"let y = ({n} m)^({n} m);",
            f"let y = sin({n} kg);",
            f"let y = atan2({n} m, {n} s);",
            f"let y = min({n} m, {n} K);",
        )
    )
    return Core(f"state x = 1; der(x) = -x; {item}", ("x",))


@generator
def widths_in_conflict(rng):
    n, m = whole(rng, 2, 4), whole(rng, 5, 7)
    item = rng.choice(
        (
            f"j : J1[{n}]; c : C[{m}](1); j -> c;",
            f"s : Se[{n}](e = zeros({m})); j : J1[{n}]; c : I[{n}](1); s -> j -> c;",
            f"let y = zeros({n}) + ones({m});",
            f"let y = eye({n})*ones({m});",
            f"let y = cross(ones({m}), ones({m}));",
            f"let y = dot(ones({n}), ones({m}));",
            f"j : J1[{n}]; c : I[{n}](eye({m})); j -> c;",
            f"a : J1[{n}]; t : TF(ones({n}, {m})); b : J1[{n}]; c : I[{n}](1); a -> t -> b -> c;",
            f"state v[{n}] = ones({m}); der(v) = -v;",
            f"let y = ones({n})[{m}];",
            f"let y = det(ones({n}, {m}));",
            f"a : J1[{n}]; x : Mux[{m}, 1]; b : J1[{m}]; c : I[{m}](1); a -> x -> b -> c;",
        )
    )
    return Core(f"state x = 1; der(x) = -x; {item}", ("x",))


# --- initial values ---------------------------------------------------------------------


@generator
def initial_values_that_differ(rng):
    a, b = number(rng), number(rng)
    item = rng.choice(
        (
            f"j : J0; x : C({a}, q0 = {b}); y : C({a}, q0 = 2*{b}); r : R(1); j -> x, y, r;",
            f"j : J1; x : I({a}, f0 = {b}); y : I({b}, f0 = 2*{b}); r : R(1); j -> x, y, r;",
            f"s : Sf({a}); j : J1; x : I({a}, f0 = 1 + {a}); r : R(1); s -> j -> x, r;",
            f"s : Se({a}); j : J0; x : C({a}, e0 = 1 + {a}); r : R(1); s -> j -> x, r;",
            f"j : J1(f0 = {a}); x : I({a}, f0 = 1 + {a}); r : R(1); j -> x, r;",
            f"j : J1; t : TF({a}); k : J1; x : I({a}, f0 = 1); y : I({b}, f0 = 1 + {a}); "
            "j -> x; j -> t -> k -> y;",
        )
    )
    return Core(f"state z = 1; der(z) = -z; {item}", ("z", "x.power"))


@generator
def initial_values_given_twice(rng):
    item = rng.choice(
        ("C(2, q0 = {a}, e0 = {a})", "I(3, p0 = {a}, f0 = {a})", "C(2, q0 = {a}, q0 = {a})")
    ).replace("{a}", number(rng))
    return Core(f"j : J1; x : {item}; r : R(1); j -> x, r;", ("r.f",))


@generator
def initial_efforts_that_no_law_reaches(rng):
    a = 1 + float(number(rng))
    law, start = rng.choice(
        (("e = tanh(q)", f"e0 = {a}"), ("e = q^2 + 1", "e0 = 0.5"), ("e = exp(q)", f"e0 = -{a}"))
    )
    return Core(f"j : J1; x : C({start}) {{ {law}; }} r : R(1); j -> x, r;", ("r.f",))


# --- equations --------------------------------------------------------------------------


@generator
def equations_without_a_solution(rng):
    a = number(rng)
    equation = rng.choice(
        (
            f"y^2 = -{a}",
            f"exp(y) = -{a}",
            f"y = y + {a}",
            f"sin(y) = 1 + {a}",
            f"0*y = {a}",
            f"abs(y) = -{a}",
            f"sqrt(y) = -{a}",
            f"1/(1 + y^2) = 1 + {a}",
            f"cosh(y) = {number(rng, 0.1, 0.9)}",
            f"y^4 + y^2 + {a} = 0",
            f"max(y, {a}) = -1",
            "floor(y) = 0.5",
        )
    )
    return Core(
        f"state x = 1; der(x) = -x; unknown y = {number(rng)}; equation {equation};", ("x", "y")
    )


@generator
def equations_with_any_solution(rng):
    a = number(rng)
    equation = rng.choice(
        (
            "y = y",
            f"0*y = 0*{a}",
            f"{a}*y = y*{a}",
            f"(y - {a})^2 = y^2 - 2*{a}*y + {a}^2",
            "sin(y)^2 + cos(y)^2 = 1",
            "y - y = 0",
            f"exp(y)*exp(-y)*{a} = {a}",
        )
    )
    return Core(
        f"state x = 1; der(x) = -x; unknown y = {number(rng)}; equation {equation};", ("x", "y")
    )


@generator
def linear_equations_that_are_dependent(rng):
    """The last row is a sum of the others; the right side agrees with it, or not."""
    n = whole(rng, 2, 4)
    rows = [[rng.randint(-4, 4) for _ in range(n)] for _ in range(n - 1)]
    last = [sum(column) for column in zip(*rows, strict=True)]
    rows.append(last)
    right = [rng.randint(-5, 5) for _ in range(n - 1)]
    right.append(sum(right) + rng.choice((0, 0, 1, 7)))
    text = f"unknown y[{n}] = zeros({n}); "
    for row, b in zip(rows, right, strict=True):
        left = " + ".join(f"({c})*y[{k}]" for k, c in enumerate(row, 1))
        text += f"equation {left} = {b}*cos(0*time); "
    return Core(f"state x = 1; der(x) = -x; {text}", ("x", "y"))


@generator
def equations_singular_by_a_parameter(rng):
    a = number(rng)
    return Core(
        f"param a = 1 + {a}; state x = 1; der(x) = -x + y; unknown y = 0; "
        f"equation (a - {a})*y = {number(rng)} + x;",
        ("x", "y"),
        f"set {{at}}a = {a};",
    )


@generator
def equations_that_lose_their_solution(rng):
    a = number(rng, 0.3, 1.5)
    equation = rng.choice(
        (
            f"y^2 = {a} - time",
            f"cosh(y) = 1 + {a} - time",
            f"exp(y) = {a} - time",
            f"sin(y) = time/{a}",
            f"y^2 + y = {a} - time",
        )
    )
    return Core(
        f"state x = 1; der(x) = -x; unknown y = {number(rng, 0.5, 2)}; equation {equation};",
        ("x", "y"),
        run="run 10 s every 0.5 s;",
    )


@generator
def equations_that_jump(rng):
    a = number(rng)
    equation = rng.choice(
        (
            f"y = if y > 0 then -{a} else {a}",
            f"y + 2*sign(y)*{a} = {a} - 2*y*0 - 2*{a}*(if y > 0 then 1 else -1)*1.5",
            f"y = -{a}*sign(y) - 0.001*y"
            if rng.random() < 0.0
            else f"y = if y > {a} then 0 else 2*{a}",
        )
    )
    return Core(
        f"state x = 1; der(x) = -x; unknown y = {number(rng)}; equation {equation};", ("x", "y")
    )


@generator
def equations_of_a_higher_index(rng):
    a = number(rng)
    return Core(
        rng.choice(
            (
                f"state x = {a}; unknown y = 0; der(x) = y; equation x = {a}*cos(time);",
                "state x = 1; state v = 0; unknown l = 0; der(x) = v; der(v) = l - x; "
                f"equation x = cos({a}*time);",
                "state x = 1; state y = 0; state u = 0; state v = 0; unknown l = 0; der(x) = u; "
                f"der(y) = v; der(u) = -l*x; der(v) = -l*y - {a}; equation x^2 + y^2 = 1;",
                f"state x = 0; state z = 0; der(x) = -x + {a}; equation der(z) = x; "
                "unknown y = 0; equation x + z = 1;",
            )
        ),
        ("x",),
    )


@generator
def equations_too_many_or_too_few(rng):
    n, m = rng.choice(((1, 0), (0, 1), (2, 1), (1, 2), (3, 2)))
    unknowns = " ".join(f"unknown y{k} = 0;" for k in range(n))
    names = [f"y{k}" for k in range(n)] or ["x"]
    equations = " ".join(
        f"equation {rng.choice(names)} + {number(rng)}*{rng.choice(names)} = {number(rng)};"
        for _ in range(m)
    )
    return Core(f"state x = 1; der(x) = -x; {unknowns} {equations}", ("x",))


@generator
def rates_given_twice_or_never(rng):
    item = rng.choice(
        (f"der(x) = -x; der(x) = -{number(rng)}*x;", "", "der(y) = x;", "der(x)[1] = 1;")
    )
    return Core(f"state x = 1; {item}", ("x",))


# --- laws -------------------------------------------------------------------------------


@generator
def laws_that_do_not_reach_an_effort(rng):
    a = 1 + float(number(rng))
    law = rng.choice((f"e = tanh({number(rng)}*f)", "e = f/(1 + abs(f))", "e = atan(f)/2"))
    return Core(f"s : Se({a}); j : J0; r : R {{ {law}; }} s -> j -> r;", ("r.f",))


@generator
def even_laws_driven_by_an_effort(rng):
    law = rng.choice(("e = f^2", "e = abs(f)", "e = cosh(f) - 1", "e = f^4", f"e = {number(rng)}"))
    return Core(
        f"s : Se(e = {number(rng)}*sin(time) - 1); j : J0; r : R {{ {law}; }} s -> j -> r;",
        ("r.f",),
    )


@generator
def laws_with_several_answers_that_fold(rng):
    """A falling part of the law: the answer jumps where the branch ends."""
    a = number(rng, 3.2, 9)
    return Core(
        f"s : Se(e = {a}*time - 2.5); j : J0; r : R {{ e = f^3 - 3*f; }} s -> j -> r;",
        ("r.f",),
        run="run 4 s every 0.1 s;",
    )


@generator
def loops_of_resistors_without_a_solution(rng):
    a = number(rng)
    return Core(
        f"v : Se(e = {a}); j : J1; a : R {{ e = f^2 + {a} + 2; }} n : J0; b : R(2);"
        "v -> j -> a; j -> n -> b;",
        ("n.e",),
    )


# --- runs -------------------------------------------------------------------------------


def _blowing_up(rng: random.Random, start: str, rate: str) -> Core:
    """A state without a value beyond some time; a fixed step passes it, with a warning."""
    solver = rng.choice(SOLVERS)
    text = f"state x = {start}; der(x) = {rate};"
    return Core(text, ("x",), solver, run="run 5 s every 0.05 s;", warns="step" in solver)


@generator
def finite_escape_times(rng):
    a, x0 = number(rng, 0.8, 20), number(rng, 0.8, 5)
    rate = rng.choice(
        (
            f"{a}*x^2",
            f"{a}*x^3",
            f"{a}*(1 + x^2)",
            f"{a}*exp(x)",
            f"{a}*x^1.5",
            f"{a}*x^4",
            f"{a}*cosh(x)",
        )
    )
    solver = rng.choice(
        (
            "",
            "solver rodas5p;",
            "solver dopri5;",
            "solver radau5;",
            "solver ros34prw; step 1 ms;",
            "solver rk4; step 1 ms;",
        )
    )
    return Core(f"state x = {x0}; der(x) = {rate};", ("x",), solver, run="run 5 s every 0.05 s;")


@generator
def finite_escape_of_a_graph(rng):
    a = number(rng, 0.8, 9)
    return Core(
        f"j : J1; m : I(1, f0 = {a}); r : R {{ e = -{a}*f^3; }} j -> m, r;",
        ("m.f",),
        run="run 5 s every 0.1 s;",
    )


@generator
def poles_in_time(rng):
    t0, a = number(rng, 0.3, 1.7), number(rng)
    rate = rng.choice(
        (f"{a}/({t0} - time)", f"{a}/({t0} - time)^2", f"{a}*tan(1.5707963267948966*time/{t0})")
    )
    return _blowing_up(rng, "1", rate)


@generator
def growth_beyond_all_numbers(rng):
    a = number(rng, 500, 5000)
    return Core(f"state x = 1; der(x) = {a}*x;", ("x",))


@generator
def states_that_leave_a_domain(rng):
    a = number(rng, 0.8, 9)
    law = rng.choice(("-sqrt(x) - {a}", "{a}*log(x) - {a}", "-{a} - x^0.5", "-{a}/sqrt(x)"))
    return Core(f"state x = 1; der(x) = {law.replace('{a}', a)};", ("x",))


@generator
def laws_that_chatter(rng):
    a = number(rng, 0.2, 5)
    item = rng.choice(
        (
            f"state x = 1; der(x) = -{a}*sign(x);",
            f"state x = 1; der(x) = if x > 0 then -{a} else {a};",
            f"state x = 1; state v = 0; der(x) = 0.1*sin(time) - {a}*sign(x); der(v) = x;",
            f"state x = 1; state v = 1; der(x) = v; der(v) = -{a}*sign(v + x) - v;",
            f"state x = 1; der(x) = if x > 0.5 then -{a} else if x > 0.4 then {a} else {a} - x;",
        )
    )
    return Core(item, ("x",), run="run 20 s every 0.5 s;")


@generator
def friction_that_sticks(rng):
    a = number(rng, 1, 9)
    return Core(
        f"s : Se(e = 0.5*{a}); j : J1; m : I({number(rng)}, f0 = 1); d : R {{ e = {a}*sign(f); }}"
        "s -> j -> m, d;",
        ("m.f",),
        run="run 60 s every 1 s;",
    )


@generator
def assertions_that_fail(rng):
    a = number(rng, 0.1, 0.9)
    return Core(f'state x = 1; der(x) = -x; assert x > {a}, "x is small";', ("x",), run="run 5 s;")


@generator
def runs_without_an_end(rng):
    run = rng.choice(
        ("", "run 0 s;", f"run -{number(rng)} s;", "run 1 s every 0 s;", "run 1 m;", "run 1/0 s;",
         f"run 1 s every -{number(rng)} s;", "run 1e400 s;", "run 1e300 s every 1e-300 s;",
         "run 1 s; run 2 s;", "step 0 s; run 1 s;", "step -1 ms; run 1 s;")
    )  # fmt: skip
    return Core("state x = 1; der(x) = -x;", ("x",), run=run)


@generator
def empty_scenes(rng):
    body, run = rng.choice(
        (("", ""), ("", "run 1 s;"), ("let a = 1;", "run 1 s;"), ("param p = 2;", "run 1 s;"))
    )
    return Core(body, run=run)


@generator
def no_scene_at_all(rng):
    return Core(rng.choice(("", "state x = 1; der(x) = -x;")), whole_scene=False)


@generator
def values_out_of_their_range(rng):
    a = number(rng)
    return Core(
        f"param p = {a} in 0..2*{a}; state x = 1; der(x) = -x*p;",
        ("x",),
        f"set {{at}}p = {rng.choice(('-1', f'3*{a}', '1e300', f'2*{a} + 1'))};",
    )


@generator
def values_that_cannot_be_set(rng):
    item, name = rng.choice(
        (("let c = 2;", "c"), ("state c = 2; der(c) = -c;", "c"),
         ("input c = 2;", "c"), ("output c = x;", "c"), ("j : J1; m : I(1); j -> m;", "m"))
    )  # fmt: skip
    return Core(f"state x = 1; der(x) = -x; {item}", ("x",), f"set {{at}}{name} = 3;")


@generator
def devices_that_do_not_exist(rng):
    device = rng.choice(
        ("omega", "phantom", 'trace(file = "nothing.csv")', "trace", 'trace(file = "")', "touch(1)")
    )
    return Core(
        "input u = 0; state x = 1; der(x) = u - x;",
        ("x",),
        f"device hand = {device}; drive {{at}}u = hand.position.x/1 m;",
    )


@generator
def solvers_out_of_place(rng):
    solver = rng.choice(
        ("solver rk4;", "solver rodas5p(rtol = -1);", "solver rodas5p(rtol = 0);",
         "solver rodas5p(step = 1 ms);", "solver rk4(rtol = 1e-3); step 1 ms;",
         "solver rodas5p(max_steps = 2);", "solver rodas5p(nothing = 1);",
         "solver rodas5p(rtol = 2);")
    )  # fmt: skip
    return Core("state x = 1; der(x) = -x;", ("x",), solver)
