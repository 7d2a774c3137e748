"""The flat graph of small models: values, parts, wiring, widths, readings, domains, equations."""

from fractions import Fraction

import pytest

from bgc.algebra.dag import Kind
from bgc.algebra.evaluate import evaluate_nodes
from bgc.elaboration.elaborate import elaborate
from bgc.ir.graph import FlatGraph, Form, Gyrator, Junction, Resistor, Source, Storage, Transformer
from bgc.resolution.resolve import load_text

RLC = """
model RLC {
  param R = 2 ohm; param L = 3 H; param C = 4 F;
  supply : Se(e = 1 V); loop : J1; coil : I(L); capacitor : C(C); resistor : R(R);
  supply -> loop; loop -> coil, capacitor, resistor;
}
"""
FRAME = """
domain Frame { effort F[2] : N; effort M : N*m; flow v[2] : m/s; flow w : rad/s;
               signal r[2] : m; }
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


def test_series_rlc():
    graph = flat(RLC)
    assert [b.name for b in graph.bonds] == [
        "supply -> loop",
        "loop -> coil",
        "loop -> capacitor",
        "loop -> resistor",
    ]
    assert {(b.effort_unit, b.flow_unit) for b in graph.bonds} == {("V", "A")}
    loop = element(graph, "loop")
    assert isinstance(loop, Junction)
    assert [(p.bond, p.sign) for p in loop.ports] == [(0, 1), (1, -1), (2, -1), (3, -1)]
    coil, capacitor = element(graph, "coil"), element(graph, "capacitor")
    assert isinstance(coil, Storage) and isinstance(capacitor, Storage)
    assert coil.law.form is Form.MOMENTUM
    assert capacitor.law.form is Form.DISPLACEMENT
    assert (coil.first_state, capacitor.first_state) == (0, 1)
    assert [(p.name, p.unit) for p in graph.parameters] == [("R", "ohm"), ("L", "H"), ("C", "F")]
    assert number(graph, coil.law.matrix[0][0]) == 3


def test_a_file_without_a_scene_observes_all_states_of_its_last_model():
    graph = flat(RLC + "model Lag { state x = 1; der(x) = -x; output y = 2*x; }")
    assert graph.scene.model == "Lag"
    assert graph.scene.duration is None
    assert graph.scene.columns == ("x", "y")
    assert flat(RLC).scene.columns == ("coil.p", "capacitor.q")


def test_declarations_come_in_any_order():
    graph = flat("model M { output y = a + b; let a = b*2; param b = c; const c = 3; }")
    assert observed(graph) == {"y": 9}


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


def test_parameters_of_parts_keep_their_own_symbol():
    graph = flat(TANK)
    names = {p.name: p for p in graph.parameters}
    assert set(names) == {"size", "tank.area", "tank.out.r"}
    store = element(graph, "tank.store")
    assert number(graph, store.law.matrix[0][0]) == Fraction(3, 10)
    graph = flat(TANK, **{"tank.area": "5"})
    assert number(graph, element(graph, "tank.store").law.matrix[0][0]) == Fraction(1, 2)
    assert number(graph, graph.parameters[0].value) == 3


def test_ports_dissolve_into_one_bond():
    graph = flat(TANK)
    assert [b.name for b in graph.bonds] == [
        "feed -> tank.node",
        "tank.node -> tank.store",
        "tank.node -> tank.out.x",
    ]


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


def test_arrays_loops_and_compile_time_if():
    text = """
      model Chain[n] {
        const last = n;
        for i in 1..n {
          let length = i*2;
          mass[i] : I(length);
          node[i] : J1;
          node[i] -> mass[i];
          if i > 1 { spring[i] : C(1); gap[i] : J0;
                     node[i-1] -> gap[i] -> node[i]; gap[i] -> spring[i]; }
          else { wall : Se(e = 0); wall -> node[1]; }
        }
        output total = mass[last].p;
      }
      scene s of Chain[3] { observe total; }
    """
    graph = flat(text)
    storage = [e for e in graph.elements if isinstance(e, Storage)]
    assert [e.name for e in storage] == ["mass[1]", "mass[2]", "mass[3]", "spring[2]", "spring[3]"]
    assert [number(graph, e.law.matrix[0][0]) for e in storage[:3]] == [2, 4, 6]


def test_a_signal_of_one_turn_is_assigned_in_a_loop_of_its_own():
    text = """
      model M {
        signal total[2];
        for i in 1..2 {
          signal term[3];
          for k in 1..3 { term[k] = 10*i + k; }
          total[i] = sum(term);
        }
      }
      scene s of M { observe total; }
    """
    assert observed(flat(text)) == {"total[1]": 36, "total[2]": 66}


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


def test_recursion_ends_by_a_dimension():
    text = """
      model Tree[n] { port p in; node : J0; leaf : R(1); p -> node -> leaf;
                      if n > 1 { next : Tree[n - 1]; node -> next; } }
      model M { s : Se(e = 1); tree : Tree[4]; s -> tree; }
    """
    assert sum(isinstance(e, Resistor) for e in flat(text).elements) == 4


def test_overrides_change_constants_and_so_structure():
    text = "model M { const n = 2; s : Se(e = 1); j : J1; s -> j; " \
           "for i in 1..n { r[i] : R(1); j -> r[i]; } }"  # fmt: skip
    assert sum(isinstance(e, Resistor) for e in flat(text, n="5").elements) == 5


def test_set_of_a_component():
    text = "model M { param v[2] = [1, 2]; output y = v; } "
    graph = flat(text + "scene s of M { set v[2] = 7; observe y; }")
    assert observed(graph) == {"y[1]": 1, "y[2]": 7}


# --- widths -----------------------------------------------------------------------------


def test_widths_come_from_brackets_arguments_and_laws():
    text = """
      model M {
        param K[3, 3] = [[2, 1, 0], [1, 2, 0], [0, 0, 1]];
        drive : Se(e = [1, 2, 3]);
        node : J1;
        field : C(stiffness = K);
        loss : R { e = K*f; }
        map : MTF { f2 = [[1, 0, 0], [0, time, 0]]*f1; }
        load : R(1);
        drive -> node;
        node -> field, loss, map;
        map -> load;
      }
    """
    graph = flat(text)
    assert [len(element(graph, n).ports) for n in ("field", "loss", "load")] == [3, 3, 2]
    transformer = element(graph, "map")
    assert isinstance(transformer, Transformer)
    assert (len(transformer.ports1), len(transformer.ports2)) == (3, 2)
    assert [e.name for e in graph.elements if isinstance(e, Junction)] == [
        "node[1]",
        "node[2]",
        "node[3]",
    ]
    assert graph.bonds[1].name == "drive -> node [2]"


def test_mux_puts_bonds_in_the_order_of_its_list():
    text = """
      model M {
        a : Se[2](e = [1, 2]); b : Se(e = 3); join : Mux[1, 2]; x : R[3](1);
        b, a -> join -> x;
      }
    """
    graph = flat(text)
    sources = {e.port.bond: number(graph, e.value) for e in graph.elements if isinstance(e, Source)}
    assert [sources[p.bond] for p in element(graph, "x").ports] == [3, 1, 2]


def test_slices_bond_components():
    text = """
      model M {
        s : Se[3](e = [1, 2, 3]); hub : J1; x : R(1); y : R[2](1);
        s -> hub; hub[2] -> x; hub[1..2] -> y;
      }
    """
    graph = flat(text)
    second = next(e for e in graph.elements if e.name == "hub[2]")
    assert len(second.ports) == 3
    assert len(next(e for e in graph.elements if e.name == "hub[3]").ports) == 1


def test_scalar_ratios_on_wide_bonds_are_as_many_transformers():
    text = "model M { s : Se[2](e = 1); t : TF(3); g : GY(2); r : R(1); s -> t -> g -> r; }"
    graph = flat(text)
    assert [e.name for e in graph.elements if isinstance(e, Transformer)] == ["t[1]", "t[2]"]
    assert [e.name for e in graph.elements if isinstance(e, Gyrator)] == ["g[1]", "g[2]"]


def test_an_element_of_given_width_takes_scalar_bonds_in_order():
    text = """
      model M {
        a : Sf(f = 1); b : Sf(f = 2); field : C[2](stiffness = [[2, 1], [1, 2]]);
        a -> field; b -> field;
      }
    """
    assert [p.bond for p in element(flat(text), "field").ports] == [0, 1]


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


def test_pseudo_domains_carry_no_power():
    text = """
      pseudo domain Heat { effort T : K; flow Q : W; }
      model Body { port p in : Heat; c : C(2 J/K); p -> c; }
      model M { s : Sf(f = 3 W); b : Body; s -> b; }
    """
    (bond,) = flat(text).bonds
    assert (bond.effort_unit, bond.flow_unit, bond.power) == ("K", "W", False)


# --- domains and the signals along bonds ------------------------------------------------

BODIES = FRAME + """
model Ground { port tip out : Frame main; param r0[2] = [1, 0]; f : Sf[3](f = zeros(3));
               f -> tip; tip.r = r0; }
model Bar { port base in : Frame; port tip out : Frame main; hub : J1; m : I[3](1);
            shift : TF { f2 = eye(3)*f1; }
            base -> hub -> shift -> tip; hub -> m;
            tip.r = base.r + [2, 0]; output at[2] = hub.r; }
model Sensor { port base in : Frame; port tip out : Frame main; base -> tip;
               output r[2] = base.r; }
model M {
  ground : Ground; one : Bar; mid : Sensor; two : Bar; end : Se[3](e = zeros(3));
  ground -> one -> mid -> two -> end;
  output middle[2] = mid.r; output inside[2] = two.at; output force[2] = two.base.F;
  output moment = mid.tip.M;
}
"""  # fmt: skip


def test_signals_pass_along_bonds_ports_and_junctions():
    graph = flat(BODIES + "scene s of M { observe middle, inside, two.tip.r as tip; }")
    assert [number(graph, o.node) for o in graph.observations] == [3, 0, 3, 0, 5, 0]
    assert graph.observations[0].unit == "m"


def test_names_of_a_domain_are_slices():
    graph = flat(BODIES + "scene s of M { observe force, moment; }")
    symbols = [graph.dag.symbol_of(o.node) for o in graph.observations]
    assert [s.kind for s in symbols] == [Kind.EFFORT] * 3
    assert [graph.bonds[s.index].effort_unit for s in symbols] == ["N", "N", "N*m"]
    assert [o.unit for o in graph.observations] == ["N", "N", "N*m"]


# --- equations --------------------------------------------------------------------------


def test_states_equations_projections_and_guards():
    text = """
      model M {
        param x0 = 2;
        state x[2] = [x0, 1];
        unknown z = 3;
        der(x[1]) = x[2];
        der(x[2]) = -z;
        equation z^3 + z = x[1];
        project x = x/2;
        assert z > 0, "z is positive";
      }
    """
    graph = flat(text)
    assert [s.name for s in graph.states] == ["x[1]", "x[2]"]
    assert number(graph, graph.states[0].initial) == 2
    assert all(s.derivative is not None and s.projection is not None for s in graph.states)
    assert graph.unknowns[0].name == "z"
    assert len(graph.equations) == 1
    assert graph.guards[0].message == "z is positive"


def test_equations_may_hold_derivatives():
    graph = flat("model M { state x = 1; equation 2*der(x) = -x; }")
    assert graph.states[0].derivative is None
    kinds = {
        graph.dag.symbol_of(n).kind
        for n in graph.dag.reachable([graph.equations[0].residual])
        if graph.dag.symbol_of(n)
    }
    assert kinds == {Kind.RATE, Kind.STATE}


def test_outputs_may_be_given_by_component():
    graph = flat("model M { output y[2]; y[2] = 5; y[1] = 4; }")
    assert observed(graph) == {"y[1]": 4, "y[2]": 5}


@pytest.mark.parametrize("part", ["m : I(2 kg)", "N : I(2 kg)"])
def test_a_part_may_have_the_name_of_a_unit(part):
    text = f"model M {{ {part}; s : Se(e = 3 N); s -> {part[0]}; let x = 4 m; }}"
    assert elaborate(load_text(text + " scene a of M { observe x; run 1 s; }")).observations
