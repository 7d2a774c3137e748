"""Models that leave the numbers, chatter or cannot run, and scenes that cannot be run."""

from __future__ import annotations

import random

from ill_posed import SOLVERS, Core, Generator, number


def _blowing_up(rng: random.Random, start: str, rate: str) -> Core:
    """A state without a value beyond some time; a fixed step passes it, with a warning."""
    solver = rng.choice(SOLVERS)
    text = f"state x = {start}; der(x) = {rate};"
    return Core(text, ("x",), solver, run="run 5 s every 0.05 s;", warns="step" in solver)


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


def finite_escape_of_a_graph(rng):
    a = number(rng, 0.8, 9)
    return Core(
        f"j : J1; m : I(1, f0 = {a}); r : R {{ e = -{a}*f^3; }} j -> m, r;",
        ("m.f",),
        run="run 5 s every 0.1 s;",
    )


def poles_in_time(rng):
    t0, a = number(rng, 0.3, 1.7), number(rng)
    rate = rng.choice(
        (f"{a}/({t0} - time)", f"{a}/({t0} - time)^2", f"{a}*tan(1.5707963267948966*time/{t0})")
    )
    return _blowing_up(rng, "1", rate)


def growth_beyond_all_numbers(rng):
    a = number(rng, 500, 5000)
    return Core(f"state x = 1; der(x) = {a}*x;", ("x",))


def states_that_leave_a_domain(rng):
    a = number(rng, 0.8, 9)
    law = rng.choice(("-sqrt(x) - {a}", "{a}*log(x) - {a}", "-{a} - x^0.5", "-{a}/sqrt(x)"))
    return Core(f"state x = 1; der(x) = {law.replace('{a}', a)};", ("x",))


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


def friction_that_sticks(rng):
    a = number(rng, 1, 9)
    return Core(
        f"s : Se(e = 0.5*{a}); j : J1; m : I({number(rng)}, f0 = 1); d : R {{ e = {a}*sign(f); }}"
        "s -> j -> m, d;",
        ("m.f",),
        run="run 60 s every 1 s;",
    )


def assertions_that_fail(rng):
    a = number(rng, 0.1, 0.9)
    return Core(f'state x = 1; der(x) = -x; assert x > {a}, "x is small";', ("x",), run="run 5 s;")


def runs_without_an_end(rng):
    run = rng.choice(
        ("", "run 0 s;", f"run -{number(rng)} s;", "run 1 s every 0 s;", "run 1 m;", "run 1/0 s;",
         f"run 1 s every -{number(rng)} s;", "run 1e400 s;", "run 1e300 s every 1e-300 s;",
         "run 1 s; run 2 s;", "step 0 s; run 1 s;", "step -1 ms; run 1 s;")
    )  # fmt: skip
    return Core("state x = 1; der(x) = -x;", ("x",), run=run)


def empty_scenes(rng):
    body, run = rng.choice(
        (("", ""), ("", "run 1 s;"), ("let a = 1;", "run 1 s;"), ("param p = 2;", "run 1 s;"))
    )
    return Core(body, run=run)


def no_scene_at_all(rng):
    return Core(rng.choice(("", "state x = 1; der(x) = -x;")), whole_scene=False)


def values_out_of_their_range(rng):
    a = number(rng)
    return Core(
        f"param p = {a} in 0..2*{a}; state x = 1; der(x) = -x*p;",
        ("x",),
        f"set {{at}}p = {rng.choice(('-1', f'3*{a}', '1e300', f'2*{a} + 1'))};",
    )


def values_that_cannot_be_set(rng):
    item, name = rng.choice(
        (("let c = 2;", "c"), ("state c = 2; der(c) = -c;", "c"),
         ("input c = 2;", "c"), ("output c = x;", "c"), ("j : J1; m : I(1); j -> m;", "m"))
    )  # fmt: skip
    return Core(f"state x = 1; der(x) = -x; {item}", ("x",), f"set {{at}}{name} = 3;")


def devices_that_do_not_exist(rng):
    device = rng.choice(
        ("omega", "phantom", 'trace(file = "nothing.csv")', "trace", 'trace(file = "")', "touch(1)")
    )
    return Core(
        "input u = 0; state x = 1; der(x) = u - x;",
        ("x",),
        f"device hand = {device}; drive {{at}}u = hand.position.x/1 m;",
    )


def solvers_out_of_place(rng):
    solver = rng.choice(
        ("solver rk4;", "solver rodas5p(rtol = -1);", "solver rodas5p(rtol = 0);",
         "solver rodas5p(step = 1 ms);", "solver rk4(rtol = 1e-3); step 1 ms;",
         "solver rodas5p(max_steps = 2);", "solver rodas5p(nothing = 1);",
         "solver rodas5p(rtol = 2);")
    )  # fmt: skip
    return Core("state x = 1; der(x) = -x;", ("x",), solver)


GENERATORS: tuple[Generator, ...] = (
    finite_escape_times,
    finite_escape_of_a_graph,
    poles_in_time,
    growth_beyond_all_numbers,
    states_that_leave_a_domain,
    laws_that_chatter,
    friction_that_sticks,
    assertions_that_fail,
    runs_without_an_end,
    empty_scenes,
    no_scene_at_all,
    values_out_of_their_range,
    values_that_cannot_be_set,
    devices_that_do_not_exist,
    solvers_out_of_place,
)
