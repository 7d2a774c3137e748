"""Ill-posed equations and laws."""

from __future__ import annotations

from ill_posed import Core, Generator, number, whole

# --- equations ---------------------------------------------------------------------------


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


def equations_singular_by_a_parameter(rng):
    a = number(rng)
    return Core(
        f"param a = 1 + {a}; state x = 1; der(x) = -x + y; unknown y = 0; "
        f"equation (a - {a})*y = {number(rng)} + x;",
        ("x", "y"),
        f"set {{at}}a = {a};",
    )


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


def equations_too_many_or_too_few(rng):
    n, m = rng.choice(((1, 0), (0, 1), (2, 1), (1, 2), (3, 2)))
    unknowns = " ".join(f"unknown y{k} = 0;" for k in range(n))
    names = [f"y{k}" for k in range(n)] or ["x"]
    equations = " ".join(
        f"equation {rng.choice(names)} + {number(rng)}*{rng.choice(names)} = {number(rng)};"
        for _ in range(m)
    )
    return Core(f"state x = 1; der(x) = -x; {unknowns} {equations}", ("x",))


def rates_given_twice_or_never(rng):
    item = rng.choice(
        (f"der(x) = -x; der(x) = -{number(rng)}*x;", "", "der(y) = x;", "der(x)[1] = 1;")
    )
    return Core(f"state x = 1; {item}", ("x",))


# --- laws --------------------------------------------------------------------------------


def laws_that_do_not_reach_an_effort(rng):
    a = 1 + float(number(rng))
    law = rng.choice((f"e = tanh({number(rng)}*f)", "e = f/(1 + abs(f))", "e = atan(f)/2"))
    return Core(f"s : Se({a}); j : J0; r : R {{ {law}; }} s -> j -> r;", ("r.f",))


def even_laws_driven_by_an_effort(rng):
    law = rng.choice(("e = f^2", "e = abs(f)", "e = cosh(f) - 1", "e = f^4", f"e = {number(rng)}"))
    return Core(
        f"s : Se(e = {number(rng)}*sin(time) - 1); j : J0; r : R {{ {law}; }} s -> j -> r;",
        ("r.f",),
    )


def laws_with_several_answers_that_fold(rng):
    """A falling part of the law: the answer jumps where the branch ends."""
    a = number(rng, 3.2, 9)
    return Core(
        f"s : Se(e = {a}*time - 2.5); j : J0; r : R {{ e = f^3 - 3*f; }} s -> j -> r;",
        ("r.f",),
        run="run 4 s every 0.1 s;",
    )


def loops_of_resistors_without_a_solution(rng):
    a = number(rng)
    return Core(
        f"v : Se(e = {a}); j : J1; a : R {{ e = f^2 + {a} + 2; }} n : J0; b : R(2);"
        "v -> j -> a; j -> n -> b;",
        ("n.e",),
    )


GENERATORS: tuple[Generator, ...] = (
    equations_without_a_solution,
    equations_with_any_solution,
    linear_equations_that_are_dependent,
    equations_singular_by_a_parameter,
    equations_that_lose_their_solution,
    equations_that_jump,
    equations_of_a_higher_index,
    equations_too_many_or_too_few,
    rates_given_twice_or_never,
    laws_that_do_not_reach_an_effort,
    even_laws_driven_by_an_effort,
    laws_with_several_answers_that_fold,
    loops_of_resistors_without_a_solution,
)
