"""Ill-posed junctions, sources, chains, ratios and parameters of elements."""

from __future__ import annotations

from ill_posed import Core, Generator, number, whole

# --- junctions and sources ---------------------------------------------------------------


def efforts_that_differ(rng):
    n = whole(rng, 2, 4)
    sources = "".join(f"s{k} : Se(e = {number(rng)}); s{k} -> j; " for k in range(n))
    return Core(f"j : J0; r : R({number(rng)}); j -> r; {sources}", ("r.f", "s0.f"))


def flows_that_differ(rng):
    n = whole(rng, 2, 4)
    sources = "".join(f"s{k} : Sf(f = {number(rng)}); s{k} -> j; " for k in range(n))
    return Core(f"j : J1; r : I({number(rng)}); j -> r; {sources}", ("r.p", "s0.e"))


def sources_in_conflict_through_gears(rng):
    n = whole(rng, 1, 4)
    chain = " -> ".join(f"t{k} -> k{k}" for k in range(n))
    parts = "".join(f"t{k} : TF({number(rng)}); k{k} : J1; " for k in range(n))
    return Core(
        f"a : Sf(f = {number(rng)}); j : J1; b : Sf(f = {number(rng)}); m : I({number(rng)});"
        f"{parts} a -> j -> {chain} -> b; j -> m;",
        ("m.p", "a.e"),
    )


def sources_in_conflict_through_a_gyrator(rng):
    return Core(
        f"a : Se(e = {number(rng)}); j : J1; g : GY({number(rng)}); k : J1; "
        f"b : Sf(f = {number(rng)}); c : C({number(rng)}); l : J0; l2 : J0; "
        f"a -> l -> g -> k; b -> k; l -> c;",
        ("c.q", "b.e"),
    )


def equal_efforts_in_parallel(rng):
    e = number(rng)
    return Core(f"a : Se(e = {e}); b : Se(e = {e}); j : J0; a -> j -> b;", ("a.f",))


def a_junction_of_sources_alone(rng):
    kind = rng.choice(("Se", "Sf"))
    junction = "J1" if kind == "Se" else "J0"
    n = whole(rng)
    sources = "".join(f"s{k} : {kind}({number(rng)}); s{k} -> j; " for k in range(n))
    return Core(f"j : {junction}; {sources}", ("s0.power", f"j.{'f' if kind == 'Se' else 'e'}"))


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


def a_ring_of_junctions(rng):
    n, kind = whole(rng, 3, 5), rng.choice(("J0", "J1"))
    source = f"Sf({number(rng)})" if kind == "J0" else f"Se({number(rng)})"
    parts = "".join(f"j{k} : {kind}; " for k in range(n))
    bonds = "".join(f"j{k} -> j{(k + 1) % n}; " for k in range(n))
    return Core(f"{parts}{bonds} s : {source}; s -> j0;", (f"j0.{'e' if kind == 'J0' else 'f'}",))


def a_ring_of_gyrators_between_sources(rng):
    a, b = number(rng), number(rng)
    return Core(
        f"a : Se({a}); j : J1; g : GY({b}); k : J1; h : GY({b}); l : J0; r : Se({a});"
        "a -> j -> g -> k -> h -> l; r -> l;",
        ("j.f",),
    )


def parts_without_bonds(rng):
    kind = rng.choice((f"R({number(rng)})", "J1", f"C({number(rng)})", "TF(2)", "Se(1)", "GY(1)"))
    return Core(f"x : {kind}; j : J1; m : I(1); r : R(1); j -> m, r;", ("m.f",))


def arrows_out_of_passive_parts(rng):
    kind = rng.choice((f"R({number(rng)})", f"C({number(rng)})", f"I({number(rng)})"))
    return Core(f"x : {kind}; j : J1; m : I(1); x -> j -> m;", ("m.f",))


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


# --- ratios and parameters of elements ---------------------------------------------------


def a_ratio_of_zero(rng):
    """The wheel would have to turn while its shaft stands still."""
    zero = rng.choice(("0", "0.0", "1 - 1", "p - p", "0*p", "p*0"))
    return Core(
        f"param p = {number(rng)}; s : Sf({number(rng)}); j : J1; t : TF({zero});"
        f"k : J1; m : I({number(rng)}); k -> m; k -> t -> j; s -> j;",
        ("m.p",),
    )


def a_ratio_that_becomes_zero(rng):
    t0 = number(rng, 0.3, 1.5)
    return Core(
        f"s : Sf({number(rng)}); k : J1; m : I({number(rng)}); t : MTF {{ f2 = (time - {t0})*f1; }}"
        "k -> m; k -> t -> j; j : J1; s -> j;",
        ("m.p", "k.f"),
    )


def storage_of_zero(rng):
    zero = rng.choice(("0", "0.0", "p - p", "1/3 - 1/3", "0*p"))
    kind = rng.choice(("I", "C"))
    return Core(
        f"param p = {number(rng)}; s : Se({number(rng)}); j : J1; x : {kind}({zero}); "
        f"r : R({number(rng)}); s -> j -> x, r;",
        ("r.f",),
    )


def storage_set_to_zero(rng):
    kind = rng.choice(("I", "C"))
    return Core(
        f"param p = {number(rng)}; s : Se({number(rng)}); j : J1; x : {kind}(p); "
        f"r : R({number(rng)}); s -> j -> x, r;",
        ("r.f",),
        "set {at}p = 0;",
    )


def negative_storage(rng):
    kind = rng.choice(("I", "C"))
    negative = rng.choice((f"-{number(rng)}", f"1 - {whole(rng, 2, 9)}", "-p"))
    return Core(
        f"param p = {number(rng)}; s : Se({number(rng)}); j : J1; x : {kind}({negative}); "
        f"r : R({number(rng)}); s -> j -> x, r;",
        ("r.f",),
        warns=True,
    )


def inertias_that_cancel(rng):
    m = number(rng)
    return Core(
        f"param m = {m}; s : Se({number(rng)}); j : J1; a : I(m); b : I(-m); r : R(1);"
        "s -> j -> a, b, r;",
        ("r.f",),
    )


def compliances_that_cancel(rng):
    c = number(rng)
    return Core(
        f"s : Sf({number(rng)}); j : J0; a : C({c}); b : C(-{c}); r : R(1); s -> j -> a, b, r;",
        ("r.e",),
    )


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


def a_resistance_of_zero_across_a_source(rng):
    zero = rng.choice(("0", "p - p", "0*p"))
    return Core(
        f"param p = {number(rng)}; s : Se({number(rng)}); j : J0; r : R({zero}); s -> j -> r;",
        ("r.f",),
    )


def a_resistance_set_to_zero(rng):
    return Core(
        f"param p = {number(rng)}; s : Se({number(rng)}); j : J0; r : R(p); s -> j -> r;",
        ("r.f",),
        "set {at}p = 0;",
    )


def a_resistance_matrix_without_inverse(rng):
    a = number(rng)
    return Core(
        f"s : Se[2](e = [1, {a}]); j : J0[2]; r : R[2]([[{a}, {a}], [{a}, {a}]]); s -> j -> r;",
        ("r.f",),
    )


def resistances_that_cancel(rng):
    r = number(rng)
    return Core(
        f"s : Se({number(rng)}); j : J1; a : R({r}); b : R(-{r}); s -> j -> a, b;", ("a.f",)
    )


def feedback_that_cancels_a_resistance(rng):
    r = number(rng)
    return Core(
        f"param k = {r}; s : Se(e = {number(rng)} + k*r.f); j : J1; r : R({r}); s -> j -> r;",
        ("r.f",),
    )


GENERATORS: tuple[Generator, ...] = (
    efforts_that_differ,
    flows_that_differ,
    sources_in_conflict_through_gears,
    sources_in_conflict_through_a_gyrator,
    equal_efforts_in_parallel,
    a_junction_of_sources_alone,
    a_ring_of_transformers,
    a_ring_of_junctions,
    a_ring_of_gyrators_between_sources,
    parts_without_bonds,
    arrows_out_of_passive_parts,
    a_closed_chain_held_twice,
    a_closed_chain_without_freedom,
    a_closed_chain_that_starts_open,
    a_ratio_of_zero,
    a_ratio_that_becomes_zero,
    storage_of_zero,
    storage_set_to_zero,
    negative_storage,
    inertias_that_cancel,
    compliances_that_cancel,
    matrices_of_storage_that_are_singular,
    a_resistance_of_zero_across_a_source,
    a_resistance_set_to_zero,
    a_resistance_matrix_without_inverse,
    resistances_that_cancel,
    feedback_that_cancels_a_resistance,
)
