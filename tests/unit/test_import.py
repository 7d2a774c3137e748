"""`bgc import`: files, messages with their places, and what is written."""

import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.grammar.format import format_source
from bgc.grammar.source_files import read_source
from bgc.options import Options
from bgc.runtime.cli.app import application
from bgc.runtime.importing.importing import Choices, import_text

ROBOTS = Path(__file__).parents[1] / "models" / "robots"
ARM = """<robot name="arm">
  <link name="base"/>
  <link name="hand">
    <inertial><mass value="2"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
  </link>
  <joint name="turn" type="revolute">
    <parent link="base"/><child link="hand"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="10" velocity="1"/>
  </joint>
</robot>
"""
BALL = '<visual><geometry><sphere radius="{}"/></geometry></visual>'
TRANSMISSION = """<transmission><joint name="turn"/><actuator>{}
<mechanicalReduction>reduction</mechanicalReduction></actuator></transmission>"""
HINGE = (
    '<mujoco><worldbody><body name="b"><joint axis="0 0 1"/><geom size="1"/>{}</body></worldbody>'
    "{}</mujoco>"
)
GRAPH = """models:
  /:
    components:
    - s base/Se e=1
    - r base/R r=2
    netlist:
    - s r
root: g
version: '0.1'
"""


def run(*arguments: object) -> Result:
    return CliRunner().invoke(application, [str(argument) for argument in arguments])


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.urdf").write_text(ARM)
    return tmp_path


def test_a_file_is_written_beside_and_never_replaced_unless_forced(folder):
    assert run("import", "arm.urdf").exit_code == 0
    text = Path("arm.bg").read_text()
    refused = run("import", "arm.urdf")
    assert refused.exit_code == 1 and "BG042" in refused.stderr and "--force" in refused.stderr
    Path("arm.bg").write_text("mine")
    assert run("import", "arm.urdf").exit_code == 1
    assert Path("arm.bg").read_text() == "mine"
    assert run("import", "arm.urdf", "--force").exit_code == 0
    assert Path("arm.bg").read_text() == text
    shown = run("import", "arm.urdf", "-o", "-")
    assert shown.stdout == text
    assert run("fmt", "--check", "arm.bg").exit_code == 0
    assert run("check", "--strict", "arm.bg").exit_code == 0
    assert run("import", "arm.urdf", "-o", "arm.txt").exit_code == 1
    assert run("import", "arm.urdf", "--force", "--package", "arm").exit_code == 2


def test_a_file_is_not_read_into_itself(folder):
    Path("graph.bg").write_text(GRAPH)
    assert "BG042" in run("import", "graph.bg").stderr
    assert run("import", "graph.bg", "-o", "mine.bg").exit_code == 0
    assert Path("graph.bg").read_text() == GRAPH


def diagnosed(tmp_path, text, kind=".urdf"):
    """Codes with the text at their places, of errors and warnings."""
    file = tmp_path / f"robot{kind}"
    file.write_text(text)
    try:
        found = import_text(file, tmp_path, Choices()).warnings
    except BgError as fault:
        found = fault.diagnostics
    assert all(d.help for d in found)
    return [(d.code, d.span.text if d.span else "") for d in found]


BOMB = '<!DOCTYPE a [<!ENTITY a "x"><!ENTITY b "&a;&a;">]>' + ARM.replace("hand", "&b;")


@pytest.mark.parametrize(
    ("old", "new", "code", "place"),
    [
        ('mass value="2"', 'mass value="-2"', "BG138", "-2"),
        ('mass value="2"', 'mass value="two"', "BG138", "two"),
        ('mass value="2"', 'mass value="nan"', "BG138", "nan"),
        ('mass value="2"', 'mass value="1e300"', "BG138", "1e300"),
        ('<mass value="2"/>', "", "BG138", "<inertial>"),
        ('izz="1"', 'izz="3"', "BG549", "2"),
        ('izz="1"', 'izz="-1"', "BG549", "2"),
        ('ixx="1" ', "", "BG138", None),
        ('xyz="0 0 1"', 'xyz="0 0"', "BG138", "0 0"),
        ('xyz="0 0 1"', 'xyz="0 0 0"', "BG138", "0 0 0"),
        ('type="revolute"', 'type="hinge"', "BG138", "hinge"),
        ('type="revolute"', "", "BG138", '<joint name="turn" >'),
        ('lower="-1"', 'lower="1"', "BG139", None),
        ('child link="hand"', 'child link="hnad"', "BG270", "hnad"),
        ('<child link="hand"/>', "", "BG270", None),
        ('child link="hand"', 'child link="base"', "BG270", None),
        ('<link name="base"/>', '<link name="base"/><link name="base"/>', "BG270", "base"),
        (
            '<link name="base"/>',
            '<link name="base"/><link name="other"/>',
            "BG270",
            '<link name="other"/>',
        ),
        ("</limit>", "", None, None),
        ("<parent", "<mimic joint='trun'/><parent", "BG270", "trun"),
        ("<parent", "<mimic joint='turn'/><parent", "BG270", None),
        ("<parent", "<dynamics damping='-1'/><parent", "BG138", "-1"),
        ("</robot>", "<gazebo/></robot>", "BG139", "<gazebo/>"),
        ("</robot>", '<xacro:macro name="a"/></robot>', "BG137", '<xacro:macro name="a"/>'),
        ("</robot>", "", "BG137", None),
        (ARM, '\n\n<?xml version="1.0" encoding="latin-1"?>' + ARM, None, None),
        (
            ARM,
            '\n<?xml version="1.0"?>' + ARM.replace('xyz="0 0 1"', 'xyz="0 é"'),
            "BG138",
            "0 é",
        ),
        ("</link>\n  <joint", BALL.format(3) + "</link>\n  <joint", None, None),
        ("</link>\n  <joint", BALL.format("3 m") + "</link>\n  <joint", "BG139", "3 m"),
        ("</robot>", TRANSMISSION.format("") + "</robot>", None, None),
        (
            "</robot>",
            TRANSMISSION.format("<rotorInertia>1</rotorInertia>") + "</robot>",
            "BG138",
            "<mechanicalReduction>",
        ),
        ('<robot name="arm">', '<sdf name="arm">', "BG137", None),
        (ARM, BOMB, "BG137", None),
        (ARM, '<!DOCTYPE a SYSTEM "file:///etc/passwd">' + ARM, None, None),
        (ARM, "<robot/>", "BG270", "<robot/>"),
        (ARM, "<robot>" + "<a>" * 2000 + "</a>" * 2000 + "</robot>", "BG137", "<a>"),
    ],
)
def test_a_fault_is_named_at_its_place(tmp_path, old, new, code, place):
    text = ARM.replace(old, new)
    if "<sdf" in new:
        text = text.replace("</robot>", "</sdf>")
    found = diagnosed(tmp_path, text)
    assert [c for c, _ in found] == ([] if code is None else [code])
    if place is not None:
        assert found[0][1] == place


def test_all_faults_are_named_at_once(tmp_path):
    text = ARM.replace('value="2"', 'value="-2"').replace('type="revolute"', 'type="hinge"')
    assert [code for code, _ in diagnosed(tmp_path, text)] == ["BG138", "BG138"]


def test_a_loop_is_refused_with_both_joints(tmp_path):
    extra = (
        '<joint name="again" type="fixed"><parent link="base"/><child link="hand"/></joint></robot>'
    )
    assert diagnosed(tmp_path, ARM.replace("</robot>", extra))[0][0] == "BG270"


@pytest.mark.parametrize(
    ("name", "way_out"),
    [("robot.urdf.xacro", "xacro robot"), ("robot.step", ".urdf"), ("m.ssp", "one by one")],
)
def test_other_kinds_of_files_are_refused(folder, name, way_out):
    refused = run("import", name)
    assert refused.exit_code == 1 and "BG137" in refused.stderr and way_out in refused.stderr


def test_a_joint_without_mass_is_fixed_and_named(tmp_path):
    text = re.sub(r"<inertial>.*</inertial>", "", ARM, flags=re.DOTALL)
    assert [code for code, _ in diagnosed(tmp_path, text)] == ["BG139"]


def test_moments_of_rounding_make_a_point(tmp_path):
    """A link of iCub has ixz = 1.4e-20 kg m^2 and no other moment: BG511 of the compiled model."""
    file = tmp_path / "arm.urdf"
    moments = '<origin xyz="0.1 0 0"/><inertia ixx="0" iyy="0" izz="0" ixz="1e-20"/>'
    file.write_text(re.sub("<inertia .*?/>", moments, ARM))
    found = import_text(file, tmp_path, Choices())
    assert "PointMass(mass = 2 kg" in found.text and not found.warnings


def test_everything_of_a_robot_is_written(tmp_path):
    result = import_text(ROBOTS / "every_joint.urdf", tmp_path, Choices())
    for text in (
        "model EveryJoint is Arm[5] {",
        "lower = 0.2, upper = 1.4",
        "DryFriction(kinetic = 0.3",
        "friction = 0.7 N*m*s",
        "telescope_rotor : I(1 kg*m^2)".replace("kg*m^2", "kg"),
        "Mimic(ratio = -1.5)",
        "mimicked(q0[5], -1.5, 0.25)",
        "PointMass(mass = 0.5 kg, com = [0.4 m, 0.1 m, 0])",
        "RotaryInertia[2]",
        'shape box(1 m, 0.5 m, 0.3 m) colour "#1a33cc";',
        "axes = rot_x(90 deg)",  # in eleven digits in the file
        "camera_at",
        "param q0[5] = [0, 0.8, 0, 0, 0]",  # inside the limits
    ):
        assert text in re.sub(r" +", " ", result.text), text
    plain = import_text(ROBOTS / "every_joint.urdf", tmp_path, Choices(limits=False))
    assert "JointStop" not in plain.text


def test_meshes_are_found_and_named_from_the_written_file(tmp_path):
    (tmp_path / "arm" / "meshes").mkdir(parents=True)
    (tmp_path / "arm" / "meshes" / "a.stl").write_bytes(b"")
    visual = (
        '<visual><geometry><mesh filename="package://arm/meshes/{}" scale="0.1 0.1 0.1"/>'
        "</geometry></visual></link>"
    )
    file = tmp_path / "urdf.urdf"
    (tmp_path / "out").mkdir()
    for name, count in (("a.stl", 0), ("b.stl", 1), ("a.dae", 1), ("../../../x.stl", 1)):
        file.write_text(ARM.replace("</link>", visual.format(name), 1))
        result = import_text(file, tmp_path / "out", Choices())
        assert ('shape mesh("../arm/meshes/a.stl", 0.1);' in result.text) is (count == 0)
        assert [w.code for w in result.warnings] == ["BG139"] * count
    elsewhere = Choices({"other": tmp_path / "arm"})
    file.write_text(ARM.replace("</link>", visual.format("a.stl").replace("//arm", "//other"), 1))
    assert "a.stl" in import_text(file, tmp_path, elsewhere).text


def test_names_that_are_words_or_not_names_are_changed(tmp_path):
    names = ["port", "2 x", "base", "x", "q", "é", "tip", "shape mesh"]
    links = "".join(f'<link name="{name}"/>' for name in names)
    joints = "".join(
        f'<joint name="{name}" type="fixed"><parent link="hand"/><child link="{name}"/></joint>'
        for name in names
        if name != "base"
    )
    text = ARM.replace('<link name="base"/>', links).replace("</robot>", f"{joints}</robot>")
    file = tmp_path / "names.urdf"
    file.write_text(text, encoding="utf-8")
    written = tmp_path / "names.bg"
    written.write_text(import_text(file, tmp_path, Choices()).text)
    compile_scene(written, Options(), until="causality")


@pytest.mark.parametrize(
    ("text", "codes"),
    [
        (HINGE.format("", ""), {"BG139"}),
        (HINGE.format("<jont/>", ""), {"BG138"}),
        (HINGE.format("", "<option wind='a'/>"), {"BG138"}),
        (HINGE.format("", "").replace("mujoco>", "robot>"), {"BG137"}),
        (HINGE.format("", "").replace('size="1"', 'size="1" mass="NaN"'), {"BG138"}),
        ("<mujoco", {"BG137"}),
    ],
)
def test_mjcf_faults_are_named(tmp_path, text, codes):
    pytest.importorskip("mujoco")
    assert {code for code, _ in diagnosed(tmp_path, text, ".xml")} == codes


def test_warnings_of_mujoco_are_diagnostics(tmp_path, monkeypatch, capfd):
    """MuJoCo 4 warns of the attribute: on the terminal, and in a log in the working folder."""
    pytest.importorskip("mujoco")
    monkeypatch.chdir(tmp_path)
    diagnosed(tmp_path, HINGE.format("", '<compiler settotalmass="1"/>'), ".xml")
    assert capfd.readouterr().err == "" and not (tmp_path / "MUJOCO_LOG.TXT").exists()


def test_bond_graph_tools_model_has_its_equations(tmp_path):
    """BondGraphTools 0.4.6 derives these equations; the charge of C1 has the other sign."""
    file = tmp_path / "two_port.bg"
    file.write_text(import_text(ROBOTS / "two_port.yaml", tmp_path, Choices()).text)
    linear = bgc.compile(file).linearise([], [])
    states = ["C1.q", "mass.p", "rotor.p"]
    order = [list(linear.states).index(name) for name in states]
    exact = np.array([[-0.8, 0, 14 / 135], [0, 0, 7 / 9], [14 / 75, -0.35, -0.357530864197531]])
    exact *= np.outer([-1, 1, 1], [-1, 1, 1])
    np.testing.assert_allclose(linear.A[np.ix_(order, order)], exact, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "code", "place"),
    [
        ("base/R", "base/BJT", "BG138", "r base/BJT r=2"),
        ("r=2", "x=2", "BG138", "r base/R x=2"),
        ("r=2", "r=two", "BG138", "r base/R r=two"),
        ("- s r", "- s q", "BG270", "s q"),
        ("- s r", "- s r\n    - s r", "BG270", "s r"),
        ("- s r", "- s", "BG270", "s"),
        ("s base/Se e=1", "s /sub", "BG138", "s /sub"),
        ("'0.1'", "'0.2'", "BG137", "'0.2'"),
        ("version", "edition", "BG137", None),
        ("root: g", "root: &a g", "BG137", "root: &a g"),
        ("root: g", "root: !!python/object g", "BG137", None),
        ("    components:", "  components:", "BG137", None),
    ],
)
def test_faults_of_bond_graph_tools_files_are_named(tmp_path, old, new, code, place):
    found = diagnosed(tmp_path, GRAPH.replace(old, new), ".yaml")
    assert [c for c, _ in found] == [code]
    if place is not None:
        assert found[0][1] == place


@pytest.mark.parametrize("file", ["every_joint.urdf", "two_port.yaml"])
def test_no_damaged_file_ends_in_a_traceback(tmp_path, file):
    text = read_source(ROBOTS / file).text
    rng = np.random.default_rng(7)
    words = [
        '"',
        "<",
        ">",
        "&x;",
        "\0",
        "é",
        "-",
        "1e999",
        "</link>",
        ": ",
        "  ",
        "\n- ",
        "'",
        "0 0",
    ]
    path = tmp_path / file
    for _ in range(60):
        damaged = text
        for _ in range(rng.integers(1, 4)):
            at, size = int(rng.integers(len(damaged))), int(rng.integers(30))
            word = words[rng.integers(len(words))] if rng.random() < 0.7 else damaged[:at][-size:]
            damaged = damaged[:at] + word + damaged[at + size * int(rng.random() < 0.5) :]
        path.write_text(damaged, encoding="utf-8")
        try:
            written = import_text(path, tmp_path, Choices()).text
        except BgError as fault:
            assert all(d.code in CODES for d in fault.diagnostics), fault
        else:
            assert format_source(read_source_text(tmp_path, written)) == written


CODES = ("BG137", "BG138", "BG270")


def read_source_text(folder, text):
    file = folder / "written.bg"
    file.write_text(text, encoding="utf-8")
    return read_source(file)
