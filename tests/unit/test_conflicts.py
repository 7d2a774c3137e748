"""Messages about refused graphs: both causes, and the way between them, in the source."""

from refusals import refusal

from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.render import render
from bgc.driver import compile_scene
from bgc.options import Options


def refused(tmp_path, text: str) -> Diagnostic:
    path = tmp_path / "m.bg"
    path.write_text(text)
    return refusal(lambda: compile_scene(path, Options(), until="equations"))


def marked(diagnostic: Diagnostic) -> dict[str, str]:
    """Underlined text -> what is said of it."""
    return {label.span.text: label.text for label in diagnostic.labels}


GEARED = """\
model M {
  battery : Se(e = 12);
  line    : J0;
  gear    : TF(3);
  bus     : J0;
  charger : Se(e = 13);
  aside   : J1;
  load    : R(2);
  other   : I(1);
  battery -> line -> gear -> bus -> aside -> load, other;
  charger -> bus;
}
"""


def test_both_causes_and_the_way_between_them_are_underlined(tmp_path):
    diagnostic = refused(tmp_path, GEARED)
    assert diagnostic.code == "BG501" and diagnostic.span.text == "charger"
    assert marked(diagnostic) == {
        "battery": "`battery` sets the effort here",
        "line": "`line` has one effort",
        "gear": "`gear` passes on the effort",
        "bus": "`bus` has one effort",
        "charger": "`charger` sets the effort too",
    }
    assert diagnostic.note == "they are connected through battery - line - gear - bus - charger"


def test_the_fault_and_what_is_said_of_it_share_a_line(tmp_path):
    text = render([refused(tmp_path, GEARED)], colour=False)
    assert "  |   ^^^^^^^ `charger` sets the effort too\n" in text
    assert text.count("charger` sets") == 1
    assert "aside" not in text.replace("charger -> bus", "")


def test_a_gyrator_on_the_way_makes_a_flow_of_an_effort(tmp_path):
    diagnostic = refused(
        tmp_path,
        """model M {
          feed : Sf(f = 1); machine : GY(3); node : J1; push : Se(e = 2);
          feed -> machine -> node; push -> node;
        }""",
    )
    said = marked(diagnostic)
    assert said["feed"] == "`feed` sets the flow here"
    assert said["machine"] == "`machine` turns it into the effort"
    assert said["node"] == "the efforts add up at `node`"


def test_the_way_runs_where_the_variables_meet_and_not_past_a_resistor(tmp_path):
    """A shorter way leads through a field of R, which gives way."""
    diagnostic = refused(
        tmp_path,
        """model M {
          a : Sf(f = 1); b : Sf(f = 2); one : J1; two : J1; gear : TF(2); far : TF(3);
          field : R[2](3);
          a -> one; b -> two; one -> gear -> far -> two;
          one -> field[1]; two -> field[2];
        }""",
    )
    assert diagnostic.note == "they are connected through a - one - gear - far - two - b"


def chain(stages: int) -> str:
    middle = "".join(f"  gear{k} : TF(2);\n  hub{k} : J1;\n" for k in range(stages))
    bonds = "".join(f"  gear{k} -> hub{k};\n" for k in range(stages))
    bonds += "".join(f"  hub{k} -> gear{k + 1};\n" for k in range(stages - 1))
    ends = f"  start -> gear0;\n  hub{stages - 1} -> stop;\n"
    return f"model M {{\n  start : Sf(f = 1);\n{middle}  stop : Sf(f = 2);\n{bonds}{ends}}}\n"


def test_a_long_way_is_told_without_its_middle(tmp_path):
    diagnostic = refused(tmp_path, chain(30))
    assert len(diagnostic.labels) == 8
    assert any(label.text.endswith("; 54 more follow") for label in diagnostic.labels)
    assert "(54 more)" in diagnostic.note
    assert render([diagnostic], colour=False).count("\n") < 30


def test_parts_of_one_declaration_are_told_once(tmp_path):
    diagnostic = refused(
        tmp_path,
        """
        model Stage { port a; port b; gear : TF(3); hub : J1; a -> gear -> hub -> b; }
        model M {
          s1 : Stage; s2 : Stage; s3 : Stage;
          first : Sf(f = 1); last : Sf(f = 2);
          first -> s1.a; s1.b -> s2.a; s2.b -> s3.a; s3.b -> last;
        }""",
    )
    said = marked(diagnostic)
    assert said["gear"] == "`s1.gear` passes on the flow, and so on for 2 more"
    assert set(said) == {"first", "gear", "hub", "last"}


def test_a_closed_rigid_chain_is_underlined_all_along(tmp_path):
    diagnostic = refused(
        tmp_path,
        """model M {
          state angle = 0.3; der(angle) = crank.f;
          crank : J1; brake : R(1); rod : MTF { f2 = cos(angle)*f1; } drive : Sf(f = 1);
          crank -> brake; crank -> rod -> drive;
        }""",
    )
    assert diagnostic.code == "BG502"
    assert set(marked(diagnostic)) == {"crank", "rod", "drive"}


def test_a_loop_without_a_single_solution_is_underlined_all_along(tmp_path):
    diagnostic = refused(
        tmp_path,
        """model M {
          boost : MSe(e = loop.f*2); loop : J1; load : R(2);
          boost -> loop -> load;
        }""",
    )
    assert diagnostic.code == "BG520"
    assert "load" in marked(diagnostic)
    assert any("in the loop" in text for text in marked(diagnostic).values())


RING = """\
model M {
  push : Se(1);
  a : J1;  b : J1;  c : J1;  d : J1;  ea : Se(1);  eb : Se(1);  ec : Se(1);  ed : Se(1);
  gab : GY(2);  gbc : GY(3);  gear : TF(2);  gda : GY(5);  aside : GY(7);  load : R(1);
  ea -> a; eb -> b; ec -> c; ed -> d;
  a -> gab -> b;
  b -> gbc -> c;
  c -> gear -> d;
  d -> gda -> a;
  push -> aside -> load;
}
"""


def test_all_gyrators_of_an_odd_loop_are_named_and_no_others(tmp_path):
    diagnostic = refused(tmp_path, RING)
    assert diagnostic.code == "BG523"
    assert "`gab`, `gbc` and `gda`" in diagnostic.message
    assert diagnostic.span.text == "gab" and set(marked(diagnostic)) == {"gbc", "gda"}
