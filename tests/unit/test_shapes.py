"""Shapes: their statements, places and poses, and their way into results and files."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from model_files import model_file, model_text

import bgc
from bgc.diagnostics.source import Source
from bgc.driver import compile_scene
from bgc.elaboration.elaborate import elaborate
from bgc.emission.emit import content_of
from bgc.grammar import syntax
from bgc.grammar.parse import parse
from bgc.ir.graph import FlatGraph
from bgc.language.shape_table import COLOURS, SHAPES
from bgc.options import Options
from bgc.resolution.modules import flatten
from bgc.resolution.resolve import load, load_text
from bgc.runtime.cli.app import application
from bgc.runtime.results.recorded_shapes import read_shapes

LIBRARY = Path(__file__).parents[2] / "library"

# --- statements -----------------------------------------------------------------------------


def shape_of(statement: str) -> syntax.Shape:
    file, wrong = parse(Source("s.bg", f"model M {{ {statement} }}"))
    assert not wrong
    (model,) = file.declarations
    (shape,) = model.items
    assert isinstance(shape, syntax.Shape)
    return shape


def test_all_of_a_statement_is_read():
    shape = shape_of('shape box(1 m, w, height = 2 m) at c + [0, 0, 1 m], rot_x(a) colour "red";')
    assert (shape.kind, shape.colour, shape.ends) == ("box", "red", None)
    assert [(a.name, a.value.span.text) for a in shape.arguments] == [
        (None, "1 m"), (None, "w"), ("height", "2 m"),
    ]  # fmt: skip
    assert shape.at.span.text == "c + [0, 0, 1 m]" and shape.axes.span.text == "rot_x(a)"
    rope = shape_of("shape rope from a.tip to b[2];")
    assert [end.span.text for end in rope.ends] == ["a.tip", "b[2]"] and rope.at is None
    assert shape_of('shape sphere(0.3) at 3 colour "red";').at.span.text == "3"


# --- poses ----------------------------------------------------------------------------------


def turn(axis: str, angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = -s, s
    return matrix


def forward(slew: float, luff: float, fold: float, swing: np.ndarray, flag: float) -> dict:
    """Poses of the crane's frames by hand: position and axes of each shape."""
    r = np.array([1.0, -2.0, 0.5])
    ground = turn("z", 0.7) @ turn("y", -0.2) @ turn("x", 0.1)
    found = {"sphere": (np.array([flag, 0, 1.0]), np.eye(3))}
    A = ground @ turn("z", slew)
    found["crane.pedestal.cylinder"] = (r, ground)  # its axis is z, which `basis` leaves
    found["crane.post.box"] = (r + A @ [0, 0, 1.5], A)
    r = r + A @ [0, 0, 3.0]
    found["crane.shoulder.cylinder"] = (r, A, A @ [0, -1, 0])
    A = A @ turn("y", -luff)
    found["crane.boom.box"] = (r + A @ [6.0, 0, 0], A, A @ [1, 0, 0])
    r = r + A @ [12.0, 0, 0]
    found["box"] = (r, A @ turn("y", 0.4))
    found["crane.elbow.cylinder"] = (r, A, A @ [0, -1, 0])
    A = A @ turn("y", -fold)
    found["crane.jib.box"] = (r + A @ [4.5, 0, 0], A, A @ [1, 0, 0])
    r = r + A @ [9.0, 0, 0]
    found["handle"] = (r, np.eye(3))
    found["arrow"] = found["load.swivel.sphere"] = (r, A)
    A = A @ swing
    found["load.rope"] = (r, r - A @ [0, 0, 5.0])
    found["load.sphere"] = (r - A @ [0, 0, 5.0], A)
    return found


@pytest.fixture(scope="module")
def crane():
    return bgc.compile(model_file("shapes_crane"))


@pytest.fixture(scope="module")
def result(crane):
    return crane.simulate(shapes=True, parameters={"flag": "3 m"})


def test_poses_agree_with_forward_kinematics(result):
    shapes = {shape.name: shape for shape in result.shapes}
    swing = np.stack([result[f"swing[{i},{j}]"] for i in (1, 2, 3) for j in (1, 2, 3)], axis=1)
    assert np.ptp(result["slew"]) > 0.05 and np.ptp(swing[:, 1]) > 0.005
    for k in range(len(result.time)):
        angles = (result[name][k] for name in ("slew", "luff", "fold"))
        expected = forward(*angles, swing[k].reshape(3, 3), 3.0)
        assert shapes.keys() == expected.keys()
        for name, (r, A, *axis) in expected.items():
            shape = shapes[name]
            if name == "load.rope":
                np.testing.assert_allclose(shape["from"][k], r, atol=1e-9)
                np.testing.assert_allclose(shape["to"][k], A, atol=1e-9)
                continue
            np.testing.assert_allclose(shape.r[k], r, atol=1e-9, err_msg=name)
            if axis:  # a body of revolution or a square bar: only its third axis is fixed
                np.testing.assert_allclose(shape.A[k] @ [0, 0, 1], axis[0], atol=1e-9)
                np.testing.assert_allclose(np.linalg.det(shape.A[k]), 1, atol=1e-9)
            else:
                np.testing.assert_allclose(shape.A[k], A, atol=1e-9, err_msg=name)


def test_arguments_and_colours_are_recorded(result):
    shapes = {shape.name: shape for shape in result.shapes}
    boom = shapes["crane.boom.box"]
    assert (boom.part, boom.kind, boom.colour) == ("crane.boom", "box", COLOURS["orange"])
    assert [boom[name][0] for name in ("length", "width", "height")] == [0.8, 0.8, 12]
    assert shapes["box"].colour == "#a0b0c0" and shapes["sphere"].colour == ""
    assert shapes["load.sphere"]["radius"].tolist() == [0.7] * len(result.time)
    weight = shapes["arrow"].A @ shapes["arrow"]["vector"][..., None]
    assert 0.5 * 2000 * 9.81 < np.abs(weight[:, 2, 0]).mean() < 2 * 2000 * 9.81
    assert shapes["arrow"]["scale"][0] == 1e-4
    with pytest.raises(KeyError):
        boom["radius"]


def test_shapes_leave_the_columns_and_the_model_alone(crane, result):
    assert list(result) == list(crane.simulate(0.1))
    assert crane.simulate(0.1).shapes == () and not crane.facts.shapes


def test_an_archive_holds_the_shapes(result, tmp_path):
    result.to_npz(tmp_path / "r.npz")
    again = read_shapes(tmp_path / "r.npz")
    assert [s.name for s in again] == [s.name for s in result.shapes]
    same = ("part", "kind", "colour", "file")
    for one, two in zip(result.shapes, again, strict=True):
        assert all(getattr(one, name) == getattr(two, name) for name in same)
        assert {*one.constant} == {*two.constant} and {*one.varying} == {*two.varying}
        for name in (*one.constant, *one.varying):
            np.testing.assert_array_equal(one[name], two[name])
    with np.load(tmp_path / "r.npz") as arrays:
        about = json.loads(str(arrays["about"]))
        entry = next(e for e in about["shapes"] if e["name"] == "load.sphere")
        assert entry["values"]["r"] == "shape:load.sphere:r"
        assert arrays["shape:load.sphere:r"].shape == (len(result.time), 3)


# --- what shapes cost -----------------------------------------------------------------------

SLIDER = """
model M {
  param size = 2 m;
  state x = 1;
  state y = 2;
  der(x) = -x;
  der(y) = x - y;
  SHAPES
}
scene s of M { observe x; run 1 s every 0.5 s; }
"""
DRAWN = SLIDER.replace(
    "SHAPES", 'shape sphere(size/2) at [y * 1 m, sin(y) * 2 m, size] colour "red"; shape sea;'
)


def graph(text: str, shapes: bool = False) -> FlatGraph:
    return elaborate(load_text(text), shapes=shapes)


def test_the_c_of_a_scene_without_shapes_is_the_same(tmp_path):
    contents = []
    for text in (SLIDER.replace("SHAPES", ""), DRAWN):
        (tmp_path / "m.bg").write_text(text, "utf-8")
        stages = compile_scene(tmp_path / "m.bg", Options(), until="emit")
        contents.append((content_of(stages.emitted), len(stages.optimised.states)))
    assert contents[0] == contents[1] and contents[0][1] == 1
    stages = compile_scene(tmp_path / "m.bg", Options(shapes=True), until="emit")
    assert len(stages.optimised.states) == 2


def test_a_position_may_be_any_expression(tmp_path):
    (tmp_path / "m.bg").write_text(DRAWN, "utf-8")
    model = bgc.compile(tmp_path / "m.bg")
    model.parameters["size"] = "3 m"
    sphere, sea = model.simulate(shapes=True).shapes
    t = np.array([0, 0.5, 1])
    y = (2 + t) * np.exp(-t)
    np.testing.assert_allclose(sphere.r, np.stack([y, 2 * np.sin(y), 3 + 0 * t], 1), rtol=1e-5)
    np.testing.assert_allclose(sphere["radius"], 1.5)
    assert sea.kind == "sea" and "waves" not in sea


def test_a_frame_without_a_position_is_reported_only_where_it_is_recorded():
    text = """import crane.beam;
      model M { turn : Sf[6](f = zeros(6)); body : RigidBody(mass = 1 kg, inertia = eye(3));
                turn -> body; shape sphere(1 m) at body; }
      scene s of M { observe turn.e; }"""
    assert graph(text).warnings == ()
    (warning,) = graph(text, shapes=True).warnings
    assert warning.code == "BG499"


def test_a_part_without_a_frame_has_that_of_the_part_around_it():
    text = """import crane.beam;
      model Lamp { shape sphere(0.1 m) at [0, 0, 1 m]; param unused = 1; }
      model Post { port base in : Frame; lamp : Lamp; body : RigidBody(mass = 1 kg,
        inertia = eye(3)); base -> body; }
      model M { ground : Ground(r0 = [1 m, 2 m, 3 m]); post : Post; ground -> post; }
      scene s of M { observe ground.tip.F; }"""
    (use,) = graph(text, shapes=True).shapes
    (r,) = (value for value in use.values if value.field == "r")
    assert use.name == "post.lamp.sphere" and len(r.columns) == 3
    assert replace(use, values=()) == graph(text).shapes[0]


def test_a_mesh_is_looked_for_beside_its_file(tmp_path):
    (tmp_path / "hull.glb").write_bytes(b"glTF")
    (tmp_path / "m.bg").write_text(
        'model M { state x = 0; der(x) = 1; shape mesh("hull.glb", scale = 0.001); }', "utf-8"
    )
    (use,) = elaborate(load(tmp_path / "m.bg"), shapes=True).shapes
    assert (use.file, use.values[0].numbers) == ("hull.glb", (0.001,))


# --- the library ----------------------------------------------------------------------------

SHOWN = model_text("shapes_shown")


def test_all_shapes_of_the_library_are_valid():
    """Every model of the library with a shape is drawn in one of the scenes."""
    text = SHOWN.replace("motor -> link.shaft", "link.shaft -> motor")
    package = load_text(text)
    drawn: set[str] = set()
    for scene in ("session", "swell", "others", "pairs"):
        found = elaborate(package, scene, shapes=True)
        assert [w for w in found.warnings if w.code == "BG499"] == []
        assert all(SHAPES[use.kind] and use.values is not None for use in found.shapes)
        drawn |= {f"{use.part.rpartition('.')[2]}.{use.kind}" for use in found.shapes}
    having = {
        model.name
        for path in LIBRARY.rglob("*.bg")
        for model in load(path).root.file.declarations
        if isinstance(model, syntax.Model)
        if any(isinstance(item, syntax.Shape) for item in flatten(model.items))
    }
    assert having == {
        "Beam", "Revolute", "Prismatic", "Spherical", "Payload", "HangingLoad", "Link", "Session",
        "FloatingHull", "Vessel", "SeakeepingHull", "SeakeepingVessel", "GuidedVessel", "Quay",
        "ShipGuided", "OffshoreLift", "CylindricalJoint", "ScrewJoint", "Planar", "Universal",
        "Rectangle", "BoxSection", "TubeSection", "ISection", "GivenSection",
        "SolidBox", "SolidCylinder", "SolidSphere",
        "RegularWave", "RollTank", "GivenWaves", "Jonswap", "Rope", "Tackle", "HookLoad",
        "GantryCrane", "GantryOnQuay", "Excavator", "ArmCell", "CraneAtSea",
        "LoadCell", "Member", "KnuckleBoomMechanism", "Gyroscope", "Swing", "Ur5", "Ur10", "Panda",
        "VirtualWall",
    }  # fmt: skip
    assert drawn >= {
        "post.box", "pedestal.cylinder", "slide.cylinder", "swivel.sphere", "payload.sphere",
        "ball.sphere", "load.rope", "load.sphere", "link.capsule", ".handle", "vessel.box",
        "vessel.sea", "vessel.hull", "sailing.hull", "boom.box", "arm.ram", "sensor.arrow",
        "sailing.box", "quay.box",
        "rod.cylinder", "nut.cylinder", "table.box", "cross.cylinder", "section.box",
        "section.cylinder", "block.box", "drum.cylinder",
    }  # fmt: skip


# --- the command line -----------------------------------------------------------------------


def test_shapes_are_asked_for_with_an_archive(tmp_path):
    path = tmp_path / "m.bg"
    path.write_text(DRAWN, "utf-8")
    run = ["run", str(path), "--shapes", "--quiet"]
    refused = CliRunner().invoke(application, [*run, "--out", str(tmp_path / "r.csv")])
    assert refused.exit_code == 2 and "--out FILE.npz" in refused.output
    done = CliRunner().invoke(application, [*run, "--out", str(tmp_path / "r.npz")])
    assert done.exit_code == 0, done.output
    assert [shape.kind for shape in read_shapes(tmp_path / "r.npz")] == ["sphere", "sea"]
    shown = CliRunner().invoke(application, ["show", str(path), "--after", "elaborate"])
    assert "shapes\n  sphere  #c0392b\n  sea\n" in shown.output
