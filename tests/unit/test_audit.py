"""The power balance that every program is checked for."""

from dataclasses import replace

import numpy as np
import pytest
from graphs import causal_of, rlc
from model_files import model_text
from refusals import codes_of

import bgc
from bgc.driver import compile_scene
from bgc.elaboration.elaborate import elaborate
from bgc.equations.audit import assert_power_balance, power_defect
from bgc.equations.derive import derive_equations
from bgc.language.column_names import AccountColumn
from bgc.options import Options
from bgc.resolution.resolve import load_text


@pytest.fixture
def program():
    graph = rlc().build()
    names = ("stored", "supplied", "dissipated")
    accounts = tuple(AccountColumn(name, f"energy.{name}") for name in names)
    return derive_equations(
        causal_of(replace(graph, scene=replace(graph.scene, accounts=accounts)))
    )


def test_derived_equations_keep_it(program):
    assert power_defect(program) < 1e-12


@pytest.mark.parametrize("which", [0, 1])
def test_a_sign_slipped_in_one_equation_is_a_bug_of_ours(program, which):
    states = list(program.states)
    slipped = program.dag.neg(states[which].derivative)
    states[which] = replace(states[which], derivative=slipped)
    with pytest.raises(AssertionError, match="power balance broken"):
        assert_power_balance(replace(program, states=tuple(states)))


HELD = model_text("audit_held")


def held(account):
    graph = elaborate(load_text(HELD.replace("ACCOUNT", account), "model.bg"))
    return derive_equations(causal_of(graph))


@pytest.mark.parametrize("account", ["stored", "dissipated"])
def test_an_account_is_kept_without_those_that_are_not_read(account):
    """The power of the device would need its acceleration, which it does not give."""
    energy = held(f"energy.{account}").energy
    zero = {name: getattr(energy, name) == 0 for name in ("stored", "supplied", "dissipated")}
    assert zero == {"stored": True, "supplied": True, "dissipated": True, account: False}


@pytest.mark.parametrize("account", ["supplied", "residual"])
def test_what_a_device_moves_rigidly_supplies_is_refused(account):
    assert codes_of(held, f"energy.{account}") == ["BG522"]


LOOPED = """
model Looped {
  node : J0; source : Sf(f = FLOW); load : R(2.5); into : Mux[1, 1]; out : Demux[1, 1];
  turn : MGY { e2 = [[1.1, 0.31], [-1.57, -(1.17/(2 + load.e))]]*f1; }
  source -> node -> load; node, node -> into -> turn -> out -> node, node;
}
scene s of Looped { observe load.e, turn.f1, turn.f2, energy.residual; run 1 s; }"""


def looped(flow):
    graph = elaborate(load_text(LOOPED.replace("FLOW", flow), "model.bg"))
    return derive_equations(causal_of(graph))


def test_powers_of_an_unknown_that_is_zero_up_to_its_solution_balance():
    assert power_defect(looped("0")) < 1e-6


def test_a_sign_slipped_in_the_powers_of_a_loop_is_found():
    program = looped("3")
    assert power_defect(program) < 1e-9
    turned = replace(program.energy, supplied=program.dag.neg(program.energy.supplied))
    assert power_defect(replace(program, energy=turned)) > 0.1


def test_a_loop_through_a_gyrator_that_its_own_effort_turns(tmp_path):
    path = tmp_path / "m.bg"
    path.write_text(LOOPED.replace("FLOW", "3"))
    result = bgc.compile(path).simulate(1.0)
    e, residual = result["load.e"][-1], abs(result["energy.residual"]).max()
    into = [result[f"turn.f1[{k}]"][-1] for k in (1, 2)]
    out = [result[f"turn.f2[{k}]"][-1] for k in (1, 2)]
    ratio = np.array([[1.1, 0.31], [-1.57, -1.17 / (2 + e)]])
    assert np.allclose(ratio @ into, e) and np.allclose(ratio.T @ out, e)
    assert np.isclose(3 + sum(out), sum(into) + e / 2.5) and residual < 1e-12


def test_numbers_whose_powers_are_rounding_are_no_broken_balance(tmp_path):
    """A centre of mass 2e9 m away: 1/6 kg m^2 of 9e18 are below the last digit."""
    path = tmp_path / "far.bg"
    path.write_text("""import mechanics.joints;
import mechanics.body;
model Far {
  ground : Ground;
  hinge  : Revolute(axis = y, angle0 = 30 deg, friction = 0.05 N*m*s, lock = Rigid[5]);
  rod    : HeavyBody(mass = 2 kg, com = [0, 2147483648, -0.5], inertia = diag([1/6, 1/6, 1e-3]));
  ground -> hinge -> rod;
}
scene far of Far { observe hinge.angle, energy.residual; run 1 s; }""")
    program = compile_scene(path, Options(), until="equations").equations
    assert power_defect(program) is None
