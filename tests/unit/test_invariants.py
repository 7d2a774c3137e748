"""States that provably never change are left out, and no others."""

from __future__ import annotations

import random
from itertools import combinations

import pytest
from graphs import causal_of
from hypothesis import given, settings
from hypothesis import strategies as st

from bgc.algebra.dag import Kind
from bgc.elaboration.elaborate import elaborate
from bgc.equations.derive import derive_equations
from bgc.ir.program import Program, Reason
from bgc.resolution.resolve import load_text
from bgc.slicing.fold import fold_parameters
from bgc.slicing.invariants import _Search, invariant_states
from bgc.slicing.slice import slice_program
from bgc.slicing.slicing_report import dropped_lines


def program_of(text: str) -> Program:
    graph = fold_parameters(elaborate(load_text(text, "model.bg"))).graph
    return derive_equations(causal_of(graph))


def invariants(text: str) -> dict[str, str]:
    """Names of the states that slicing finds to stay, with the reason."""
    dropped = slice_program(program_of(text)).dropped
    return {d.name: d.reason.name for d in dropped if d.reason is not Reason.UNREAD}


def equations(*lines: str, observe: str, scene: str = "") -> str:
    body = "\n".join(lines)
    return f"model M {{ {body} }}\nscene s of M {{ observe {observe}; {scene} run 1 s; }}"


def beside(text: str, observe: str, scene: str = "") -> str:
    """The equations beside one that moves in any case."""
    moving = "state moving = 1; der(moving) = -moving;"
    return equations(moving, text, observe=f"moving, {observe}", scene=scene)


OSCILLATORS = (
    "state a = 1; state b = 0; der(a) = b; der(b) = -a;",
    "state c = 0; state d = 0; der(c) = d; der(d) = -c + c*a;",
)


def test_what_nothing_pushes_stays_at_zero() -> None:
    assert invariants(equations(*OSCILLATORS, observe="a, c")) == {"c": "ZERO", "d": "ZERO"}


def test_what_is_observed_of_it_is_zero() -> None:
    program = slice_program(program_of(equations(*OSCILLATORS, observe="a, c")))
    assert [s.name for s in program.states] == ["a", "b"]
    assert program.observations[1].node == program.dag.zero
    assert program.observations[0].node == program.dag.symbol(Kind.STATE, 0)


def test_keep_leaves_it() -> None:
    assert invariants(equations(*OSCILLATORS, observe="a, c", scene="keep c;")) == {}


def test_where_nothing_moves_everything_is_kept() -> None:
    """Such a scene is there for its modes."""
    still = equations("state c; state d; der(c) = d; der(d) = -c;", observe="c")
    program = slice_program(program_of(still))
    assert [s.name for s in program.states] == ["c", "d"] and not program.dropped


def test_a_start_that_may_be_set_is_no_zero() -> None:
    text = "param start = 0; state c = start; state d = 0; der(c) = d; der(d) = -c;"
    assert invariants(beside(text, observe="c")) == {}
    fixed = beside(text, observe="c", scene="set start = 0;")
    assert invariants(fixed) == {"c": "ZERO", "d": "ZERO"}


def test_a_device_may_push() -> None:
    text = """
    model M { input x = 0; state c; der(c) = x - c; state a = 1; der(a) = -a; }
    scene s of M { device hand = trace(file = "a.csv"); drive x = hand.position[1];
      observe a, c; run 1 s; }
    """
    assert invariants(text) == {}
    assert invariants(text.replace("hand.position[1]", "0*hand.position[1]")) == {"c": "ZERO"}


def test_the_time_may_push() -> None:
    assert invariants(equations("state c; der(c) = sin(time);", observe="c")) == {}


def test_what_never_changes_becomes_its_start() -> None:
    text = "param h = 2; state c = h^2; state d; der(c) = 0; der(d) = c;"
    program = slice_program(program_of(equations(text, observe="d")))
    assert [(d.name, d.reason) for d in program.dropped] == [("c", Reason.CONSTANT)]
    h = program.dag.symbol(Kind.PARAM, 0)
    assert program.states[0].derivative == program.dag.mul(h, h)


def test_an_equilibrium_for_all_parameters_is_one() -> None:
    text = "param m = 2; param k = 3; state q = m*9.81/k; state v; der(q) = v; "
    assert set(invariants(beside(text + "der(v) = 9.81 - k*q/m;", observe="q"))) == {"q", "v"}
    assert invariants(beside(text + "der(v) = 9.8 - k*q/m;", observe="q")) == {}


def test_zeros_that_only_an_identity_shows_are_seen() -> None:
    """sin^2 + cos^2 - 1 does not fold."""
    text = "state a = 1; der(a) = -a; state c; der(c) = sin(a)^2 + cos(a)^2 - 1 + c;"
    assert invariants(equations(text, observe="a, c")) == {"c": "ZERO"}


@pytest.mark.parametrize(
    ("clamp", "stays"),
    [
        ("min(max(c, -limit), limit)", True),  # limit is never negative
        ("max(c, low)", False),
        ("min(c, low)", False),
        ("max(c, limit)", False),
        ("max(c, -limit) - min(c, limit*2)", True),
        ("max(c, limit*depth)", True),  # depth is never positive
        ("min(c, limit*depth)", False),
        ("min(c, depth*depth)", True),
        ("max(c, depth - limit)", True),
        ("min(c, limit - other)", False),  # of two that are never negative
        ("max(c, limit - other)", False),
    ],
)
def test_clamps_are_told_by_the_ranges_of_parameters(clamp: str, stays: bool) -> None:
    limits = "param limit = 2 in 0 .. 5; param other = 3 in 0 .. 5; param depth = -1 in -5 .. 0;"
    text = f"{limits} param low = -1; state c; der(c) = {clamp};"
    assert bool(invariants(beside(text, observe="c"))) is stays


def test_a_quaternion_that_turns_about_one_axis_keeps_two_components() -> None:
    text = """
    import mechanics.pose;
    model M { param rate = 1; pose : Pose(twist = [0, 0, 0, 0, rate, 0]); }
    scene s of M { observe pose.A; run 1 s; }
    """
    assert set(invariants(text)) == {"pose.attitude.h[2]", "pose.attitude.h[4]"}


def test_a_projection_has_to_leave_it_too() -> None:
    text = "state c; der(c) = 0; project c = {to}; state d; der(d) = c;"
    assert invariants(beside(text.format(to="1"), observe="d")) == {}
    assert set(invariants(beside(text.format(to="2*c"), observe="d"))) == {"c", "d"}


def test_what_a_projection_reads_is_kept() -> None:
    text = "state c = 1; der(c) = -c; project c = d; state d = 1; der(d) = -2*d;"
    program = slice_program(program_of(equations(text, observe="c")))
    assert [state.name for state in program.states] == ["c", "d"]


def test_a_start_that_depends_on_when_it_is_stays_a_state() -> None:
    text = "state c = cos(time); der(c) = 0; state d; der(d) = c;"
    assert invariants(beside(text, observe="d")) == {}


COUPLED = "state a = 1; state b; equation der(a) + {m}*der(b) = -a; equation der(b) = -b*a;"


def test_rows_of_a_mass_matrix_count() -> None:
    assert invariants(equations(COUPLED.format(m=2), observe="a")) == {"b": "ZERO"}
    mixed = "state a = 1; state b; equation der(a) = -a; equation der(b) + 2*der(a) = -b;"
    assert invariants(equations(mixed, observe="a, b")) == {}


def test_algebraic_rows_that_hold_at_zero() -> None:
    text = "state a = 1; der(a) = -a + z; unknown z = 0; equation z + z^3 = {right};"
    assert "z" in invariants(equations(text.format(right="0*a"), observe="a"))
    assert invariants(equations(text.format(right="a - 1/2"), observe="a")) == {}


def test_a_model_without_a_scene_keeps_everything() -> None:
    program = program_of("model M { state c; der(c) = -c; }")
    assert len(slice_program(program).states) == 1


TERMS = st.tuples(st.integers(-2, 2), st.integers(0, 3), st.integers(0, 3))


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.lists(TERMS, max_size=3), min_size=4, max_size=4),
    st.lists(st.sampled_from([0, 0, 0, 1]), min_size=4, max_size=4),
)
def test_the_greatest_set_that_confirms_itself_is_found(
    rates: list[list[tuple[int, int, int]]], start: list[int]
) -> None:
    """Against all subsets of four states with x[i]' = sum of c x[j] x[k], in whole numbers."""
    lines = [
        f"state x{i} = {start[i]}; der(x{i}) = "
        + " + ".join(["0", *(f"({c})*x{j}*x{k}" for c, j, k in rates[i])])
        + ";"
        for i in range(4)
    ]
    program = program_of(beside("\n".join(lines), observe="x0, x1, x2, x3"))
    found = {program.states[index].name for index in invariant_states(program)}

    def confirms(members: tuple[int, ...]) -> bool:
        rng = random.Random(1)
        for _ in range(3):
            x = [start[i] if i in members else rng.randint(2, 10**6) for i in range(4)]
            if any(sum(c * x[j] * x[k] for c, j, k in rates[i]) for i in members):
                return False
        return True

    subsets = (m for size in range(5) for m in combinations(range(4), size))
    expected = {f"x{i}" for members in subsets if confirms(members) for i in members}
    assert found == expected


def chain(count: int) -> Program:
    """Masses and springs in a row, all at rest, the first one pulled."""
    return program_of(
        f"""
        model M {{
          pull : Se(e = 1);
          for k in 1..{count} {{ mass[k] : I(1); hub[k] : J1; node[k] : J0; spring[k] : C(1); }}
          pull -> hub[1];
          for k in 1..{count} {{ hub[k] -> mass[k]; hub[k] -> node[k] -> spring[k]; }}
          for k in 1..{count - 1} {{ node[k] -> hub[k + 1]; }}
          node[{count}] -> last; last : J1; last -> tip; tip : I(1);
        }}
        scene s of M {{ observe tip.p; run 1 s; }}
        """
    )


def test_a_chain_that_is_pulled_moves_and_costs_in_proportion() -> None:
    sizes = []
    for count in (40, 80):
        program = chain(count)
        assert invariant_states(program) == {}
        search = _Search(program)
        before, looked, suspects = len(search._dag), 0, list(search.values)
        while suspects:
            looked += len(suspects)
            suspects = search.release(search.moving(suspects))
        sizes.append((looked, len(search._dag) - before))
    for small, large in zip(*sizes, strict=True):
        assert large <= 2.2 * small + 10


def test_what_is_dropped_is_told_by_parts() -> None:
    text = """
    model Spring { port p in; param k = 1; rod : C(k); loss : R(1); n : J1; p -> n -> rod, loss; }
    model M {
      push : Se(e = 1); body : I(1); hub : J1; spring : Spring; push -> hub -> body, spring;
      still : J1; rest : I(2); other : Spring; none : Se(e = 0); none -> still -> rest, other;
      alone : J1; odd : I(2); lone : Se(e = 1); lone -> alone -> odd;
    }
    scene s of M { observe body.p, other.rod.q; run 1 s; }
    """
    program = slice_program(program_of(text))
    lines = dropped_lines(program.dropped, [s.name for s in program.states])
    assert lines == (
        "`odd` (1 state): nothing that the scene reads depends on it",
        "`rest` (1 state): starts at zero and stays there",
        "`other` (1 state): starts at zero and stays there",
    )
