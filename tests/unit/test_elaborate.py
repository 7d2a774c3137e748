"""The flat graph of small models: values, parts, wiring, widths, readings, domains, equations."""

from fractions import Fraction

import pytest

from bgc.algebra.dag import Kind
from bgc.algebra.evaluate import evaluate_nodes
from bgc.elaboration.elaborate import elaborate
from bgc.ir.graph import FlatGraph, Resistor
from bgc.resolution.resolve import load_text

RLC = """
model RLC {
  param R = 2 ohm; param L = 3 H; param C = 4 F;
  supply : Se(e = 1 V); loop : J1; coil : I(L); capacitor : C(C); resistor : R(R);
  supply -> loop; loop -> coil, capacitor, resistor;
}
"""


def flat(text: str, scene: str | None = None, **sets: str) -> FlatGraph:
    return elaborate(load_text(text), scene, tuple(sets.items()))


def element(graph: FlatGraph, name: str):
    (found,) = [e for e in graph.elements if e.name == name]
    return found


def number(graph: FlatGraph, node: int) -> Fraction:
    """The exact value of a node, parameters at their defaults."""
    defaults = {graph.dag.symbol(Kind.PARAM, p.index): p.value for p in graph.parameters}
    found = node
    for _ in range(5):  # a default may hold other parameters
        (found,) = graph.dag.substitute([found], defaults)
    exact = graph.dag.value(found)
    assert exact is not None
    return exact


def observed(graph: FlatGraph) -> dict[str, Fraction]:
    return {o.name: number(graph, o.node) for o in graph.observations}


# --- plain graphs -----------------------------------------------------------------------


def test_a_file_without_a_scene_observes_all_states_of_its_last_model():
    graph = flat(RLC + "model Lag { state x = 1; der(x) = -x; output y = 2*x; }")
    assert graph.scene.model == "Lag"
    assert graph.scene.duration is None
    assert graph.scene.columns == ("x", "y")
    assert flat(RLC).scene.columns == ("coil.p", "capacitor.q")


def test_the_same_text_gives_the_same_graph():
    assert repr(flat(RLC).elements) == repr(flat(RLC).elements)


# --- models, arguments, slots -----------------------------------------------------------

TANK = """
interface Outlet { port p in; }
model Pipe is Outlet { port p in; param r = 1; x : R(r); p -> x; }
model Wide is Pipe(r = 1/2) { let twice = 2*r; }
model Tank { port q in; param area = 2; node : J0; store : C(area/10); out : Outlet = Pipe;
             q -> node -> store; node -> out; output level = store.e; }
model Plant { param size = 3; feed : Sf(f = 1); tank : Tank(area = size); feed -> tank; }
"""


def test_slots_are_filled_by_default_argument_and_scene():
    assert number(flat(TANK), element(flat(TANK), "tank.out.x").law.matrix[0][0]) == 1
    graph = flat(TANK + "scene s of Plant { use tank.out = Wide; observe tank.out.twice; }")
    assert observed(graph) == {"tank.out.twice": 1}
    graph = flat(TANK + "scene s of Plant { use tank.out = Pipe(r = 7); observe tank.out.r; }")
    assert observed(graph) == {"tank.out.r": 7}
    text = TANK.replace("Tank(area = size)", "Tank(area = size, out = Wide(r = size))")
    assert observed(flat(text + "scene s of Plant { observe tank.out.r; }")) == {"tank.out.r": 3}


def test_a_slot_hands_its_own_arguments_to_whatever_fills_it():
    text = """
      interface Follows { input u; output y; }
      model Twice is Follows { input u; output y = 2*u; }
      model Thrice is Follows { input u; output y = 3*u; }
      model M { f : Follows(u = 5) = Twice; output z = f.y; }
    """
    assert observed(flat(text)) == {"z": 10}
    assert observed(flat(text + "scene s of M { use f = Thrice; observe z; }")) == {"z": 15}


def test_arguments_are_read_where_they_are_written():
    text = """
      model Inner { param a = 1; param b = a; }
      model M { param a = 10; part : Inner(b = a); output y = part.b; }
    """
    assert observed(flat(text)) == {"y": 10}


def test_a_thousand_masses_are_quick():
    text = """
      model Chain[n] {
        wall : Sf(f = 0);
        for i in 1..n { mass[i] : I(1); hub[i] : J1; gap[i] : J0; spring[i] : C(2);
                        hub[i] -> mass[i]; gap[i] -> spring[i]; gap[i] -> hub[i]; }
        wall -> gap[1];
        for i in 2..n { hub[i-1] -> gap[i]; }
      }
      scene s of Chain[1000] { observe mass[1000].f as tip; }
    """
    assert len(flat(text).bonds) == 4000


# --- widths -----------------------------------------------------------------------------


# --- readings and units -----------------------------------------------------------------


def test_power_is_positive_into_elements_and_out_of_sources():
    graph = flat(
        "model M { s : Se(e = 1); j : J1; t : Se(e = 2); r : R(1); s -> j; j -> t, r;"
        " output a = s.power; output b = t.power; output c = r.power; }"
    )
    values = {}
    for observation in graph.observations:
        for node in graph.dag.reachable([observation.node]):
            if graph.dag.symbol_of(node):
                values[graph.dag.symbol_of(node)] = 3.0
    powers = evaluate_nodes(graph.dag, [o.node for o in graph.observations], values)
    assert powers == [9, -9, 9]


def test_a_mass_fixes_the_units_of_its_bond():
    graph = flat("model M { s : Se(e = 3); m : I(2 kg); s -> m; }")
    assert (graph.bonds[0].effort_unit, graph.bonds[0].flow_unit) == ("N", "m/s")


def test_units_pass_through_transformers():
    graph = flat("model M { s : Se(e = 3 N); t : TF(2 m^-1); r : R(1); s -> t -> r; }")
    assert graph.bonds[1].effort_unit == "N*m"
    assert graph.bonds[1].flow_unit == "rad/s"


def test_plain_numbers_leave_the_units_of_bonds_open():
    graph = flat(
        "model M { s : MSe(e = sin(3*time)); r : R(2 + tanh(1)); j : J1; s -> j -> r, c, d;"
        " c : C { e = q + q^3; } d : C { e = sinh(q); } k : C { H = q^2 + 1 - cos(q); } j -> k; }"
    )
    assert {(bond.effort_unit, bond.flow_unit) for bond in graph.bonds} == {("", "")}


def test_pseudo_domains_carry_no_power():
    text = """
      pseudo domain Heat { effort T : K; flow Q : W; }
      model Body { port p in : Heat; c : C(2 J/K); p -> c; }
      model M { s : Sf(f = 3 W); b : Body; s -> b; }
    """
    (bond,) = flat(text).bonds
    assert (bond.effort_unit, bond.flow_unit, bond.power) == ("K", "W", False)


def test_elements_that_couple_a_pseudo_bond_carry_no_power_at_all():
    graph = flat("""
      pseudo domain Heat { effort T : K; flow Q : W; }
      domain Line { effort F : N; flow v : m/s; }
      model Body {
        port p in : Heat;
        port q in : Line;
        shape : TF(ratio = 2);
        node  : J0;
        store : C[2](compliance = [[2, 1], [1, 2]]);
        other : J0;
        drive : GY(ratio = 3);
        p -> shape -> node;
        node, other -> store;
        node -> drive -> q2;
        q2 : J1;
        q -> q2;
      }
      model M { s : Se(300 K); push : Se(1 N); b : Body; s -> b.p; push -> b.q; }
    """)
    power = {bond.name: bond.power for bond in graph.bonds}
    assert not power["b.node -> b.store"]
    assert not any(on for name, on in power.items() if "b.other" in name or "b.shape" in name)
    assert power["b.drive -> b.q2"]


# --- domains and the signals along bonds ------------------------------------------------

# --- equations --------------------------------------------------------------------------


@pytest.mark.parametrize("part", ["m : I(2 kg)", "N : I(2 kg)"])
def test_a_part_may_have_the_name_of_a_unit(part):
    text = f"model M {{ {part}; s : Se(e = 3 N); s -> {part[0]}; let x = 4 m; }}"
    assert elaborate(load_text(text + " scene a of M { observe x; run 1 s; }")).observations


def test_recursion_ends_by_a_dimension():
    text = """
      model Tree[n] { port p in; node : J0; leaf : R(1); p -> node -> leaf;
                      if n > 1 { next : Tree[n - 1]; node -> next; } }
      model M { s : Se(e = 1); tree : Tree[4]; s -> tree; }
    """
    assert sum(isinstance(e, Resistor) for e in flat(text).elements) == 4


CHAIN = """
interface Train[n] { port a in; }
model Springs[n = 4] is Train[n] {
  port a in;
  for i in 1..n { gap[i] : J0; spring[i] : C(i); gap[i] -> spring[i]; }
  a -> gap[1];
  for i in 2..n { gap[i - 1] -> gap[i]; }
}
model Wide[k = 2] { train : Train[k] = Springs[k]; own : Springs[5]; push : Sf[2](f = [1, 1]);
  split : Demux[1, 1]; push -> split; split -> train.a, own.a; }
"""


def sizes(graph: FlatGraph) -> dict[str, tuple[tuple[str, int], ...]]:
    return {part.path: part.dims for part in graph.parts if part.dims}


def test_a_scene_sets_a_dimension_of_any_part():
    """The command line too, and whether the size is written or the model's own."""
    text = f"{CHAIN} scene s of Wide {{ set own.n = 3; set k = 2; run 1 s; }}"
    found = sizes(flat(text))
    assert found == {"": (("k", 2),), "train": (("n", 2),), "own": (("n", 3),)}
    found = sizes(flat(text, **{"k": "1 + 2", "own.n": "1"}))
    assert found == {"": (("k", 3),), "train": (("n", 3),), "own": (("n", 1),)}
