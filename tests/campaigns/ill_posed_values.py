"""Ill-posed values, names, units, widths and initial values."""

from __future__ import annotations

from ill_posed import Core, Generator, number, whole

# --- values ------------------------------------------------------------------------------


def divisions_by_zero(rng):
    zero = rng.choice(("0", "(q - q)", "(1 - 1)", "sin(0)", "(2*q - q - q)", "0^2", "min(0, q)"))
    return Core(
        f"param q = {number(rng)}; param p = {number(rng)}/{zero}; state x = 1; der(x) = -x*p;",
        ("x",),
    )


def divisions_by_a_parameter_set_to_zero(rng):
    return Core(
        f"param q = {number(rng)}; state x = 1; der(x) = -x/q; let y = {number(rng)}/q;",
        ("x", "y"),
        "set {at}q = 0;",
    )


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


def values_in_a_circle(rng):
    n, kind = whole(rng, 1, 6), rng.choice(("param", "let", "const", "signal"))
    text = " ".join(f"{kind} a{k} = a{(k + 1) % n}*{number(rng)} + 1;" for k in range(n))
    return Core(f"{text} state x = 1; der(x) = -x*a0;", ("x",))


def functions_in_a_circle(rng):
    n = whole(rng, 1, 5)
    text = " ".join(f"function f{k}(x) = f{(k + 1) % n}(x) + 1;" for k in range(n))
    return Core("state x = 1; der(x) = -f0(x);", ("x",), declarations=text)


def models_in_a_circle(rng):
    n, twice = whole(rng, 1, 4), whole(rng, 1, 3)
    text = " ".join(
        f"model A{k} {{ {' '.join(f'p{i} : A{(k + 1) % n};' for i in range(twice))} }}"
        for k in range(n)
    )
    return Core("state x = 1; der(x) = -x; deep : A0;", ("x",), declarations=text)


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


def slots_without_a_part(rng):
    n = whole(rng, 1, 3)
    parts = " ".join(f"s{k} : Any;" for k in range(n))
    return Core(
        f"state x = 1; der(x) = -x; {parts}",
        ("x",),
        declarations="interface Any { output y; }",
    )


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


# --- initial values ----------------------------------------------------------------------


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


def initial_values_given_twice(rng):
    item = rng.choice(
        ("C(2, q0 = {a}, e0 = {a})", "I(3, p0 = {a}, f0 = {a})", "C(2, q0 = {a}, q0 = {a})")
    ).replace("{a}", number(rng))
    return Core(f"j : J1; x : {item}; r : R(1); j -> x, r;", ("r.f",))


def initial_efforts_that_no_law_reaches(rng):
    a = 1 + float(number(rng))
    law, start = rng.choice(
        (("e = tanh(q)", f"e0 = {a}"), ("e = q^2 + 1", "e0 = 0.5"), ("e = exp(q)", f"e0 = -{a}"))
    )
    return Core(f"j : J1; x : C({start}) {{ {law}; }} r : R(1); j -> x, r;", ("r.f",))


GENERATORS: tuple[Generator, ...] = (
    divisions_by_zero,
    divisions_by_a_parameter_set_to_zero,
    values_outside_of_a_function,
    values_in_a_circle,
    functions_in_a_circle,
    models_in_a_circle,
    names_that_nothing_declares,
    slots_without_a_part,
    units_in_conflict,
    widths_in_conflict,
    initial_values_that_differ,
    initial_values_given_twice,
    initial_efforts_that_no_law_reaches,
)
