"""Systems of FMUs: the archive as FMPy and libcosim read it, and runs against exact samples."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree
from zipfile import ZipFile

import numpy as np
import pytest
from click.testing import CliRunner
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd, read_ssv
from lxml import etree
from scipy.linalg import expm

from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.cli.app import application
from bgc.runtime.fmi import binaries

MODELS = Path(__file__).parents[1] / "models" / "spring_loop.bg"
CLOSED = ("--part", "loop=:loop", "--connect", "spring_loop_plant.place -> loop.at",
          "--connect", "loop.force -> spring_loop_plant.push")  # fmt: skip
STEP = 0.01


def build(out: Path, *arguments: str, scene: str = "plant") -> str:
    command = ["build", str(MODELS), "--target", "ssp", "--scene", scene, "-o", str(out)]
    result = CliRunner().invoke(application, [*command, *arguments])
    if isinstance(result.exception, BgError):
        return str(result.exception)
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result.output


@pytest.fixture(scope="module")
def archive(tmp_path_factory) -> Path:
    """The closed loop, built without optimisation: compile time is most of this test."""
    out = tmp_path_factory.mktemp("system")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(binaries, "_FLAGS", ("-std=c11", "-O0", "-fPIC", "-fvisibility=hidden"))
        printed = build(out, *CLOSED)
    assert printed.strip() == str(out / "spring_loop_plant.ssp")
    return out / "spring_loop_plant.ssp"


def exact(steps: int, force: float, goals: np.ndarray, k: float = 40.0) -> np.ndarray:
    """Positions at the steps: mass, spring and damper under a force that is held in each step.

    The controller integrates what it is given at the beginning of a step; each part gets what the
    other one gave at the end of the step before. `force` is that of the first step.
    """
    plant = np.array([[-3 / 2, -k, 1.0], [1 / 2, 0.0, 0.0], [0.0, 0.0, 0.0]])  # p, q, held force
    held = expm(plant * STEP)
    p, q, sums = 0.0, 0.1, 0.0
    at, found = q if force else 0.0, [q]
    for n in range(steps):
        p, q, _ = held @ (p, q, force)
        sums += STEP * (goals[n] - at)
        force = 60.0 * (goals[n + 1] - at) + 100.0 * sums
        at = q
        found.append(q)
    return np.array(found)


def goals(steps: int) -> np.ndarray:
    return np.where(np.arange(steps + 1) * STEP < 0.5 - 1e-9, 0.0, 0.2)


def test_the_archive_is_valid_and_complete(archive, tmp_path):
    structure = read_ssd(str(archive))  # compares with the schema
    parts = {part.name: part for part in structure.system.elements}
    assert sorted(parts) == ["loop", "spring_loop_plant"]
    kinds = {c.name: c.kind for c in parts["loop"].connectors}
    assert kinds == {"at[1]": "input", "at[2]": "input", "force": "output"}
    wires = {
        (c.startElement, c.startConnector, c.endElement, c.endConnector)
        for c in structure.system.connections
    }
    assert wires == {
        ("spring_loop_plant", "place[1]", "loop", "at[1]"),
        ("spring_loop_plant", "place[2]", "loop", "at[2]"),
        ("loop", "force", "spring_loop_plant", "push"),
    }
    units = {u.name: (u.kg, u.m, u.s) for u in structure.units}
    assert units["N"] == (1, 1, -2) and units["m"] == (0, 1, 0)
    with ZipFile(archive) as files:
        files.extractall(tmp_path)
    text = (tmp_path / "SystemStructure.ssd").read_text()
    assert 'stopTime="2.0"' in text and 'baseStepSize="0.01"' in text
    # `soft` follows from `k`, and would no longer do so if the set had it.
    values = read_ssv(str(tmp_path / "resources" / "spring_loop_plant.ssv"))
    assert [(p.name, float(p.value)) for p in values.parameters] == [("k", 40.0)]
    schemas = Path(__import__("fmpy").__file__).parent / "ssp" / "schema"
    schema = etree.XMLSchema(file=str(schemas / "SystemStructureParameterValues.xsd"))
    schema.assertValid(etree.parse(tmp_path / "resources" / "loop.ssv"))


def test_fmpy_runs_the_system(archive):
    steps = 200
    found = simulate_ssp(str(archive), stop_time=(steps - 0.5) * STEP, step_size=STEP)
    wanted = exact(steps, 0.0, goals(steps))
    np.testing.assert_allclose(found["spring_loop_plant.place[1]"], wanted[1:], atol=1e-7)
    assert np.ptp(wanted) > 0.2


def run_by_libcosim(start, plant: str, steps: int) -> float:
    """Run a system that `start` opens; return the last `place[1]` of its part `plant`."""
    observers = pytest.importorskip("libcosimpy.CosimObserver")
    run = start(pytest.importorskip("libcosimpy.CosimExecution").CosimExecution)
    observer = observers.CosimObserver.create_last_value()
    run.add_observer(observer)
    (slave,) = [s.index for s in run.slave_infos() if s.name == plant.encode()]
    (place,) = [v.reference for v in run.slave_variables(slave) if v.name == b"place[1]"]
    assert run.simulate_until(target_time=steps * int(STEP * 1e9))
    (found,) = observer.last_real_values(slave_index=slave, variable_references=[place])
    return found


def test_libcosim_runs_the_system_with_its_parameter_set(archive, tmp_path):
    """The stiffness is changed in the set: libcosim applies it. The first force is exchanged."""
    with ZipFile(archive) as files:
        files.extractall(tmp_path)
    values = tmp_path / "resources" / "spring_loop_plant.ssv"
    values.write_text(values.read_text().replace("40.0", "80.0"))
    steps = 200
    found = run_by_libcosim(
        lambda execution: execution.from_ssp_file(ssp_path=str(tmp_path)),
        "spring_loop_plant",
        steps,
    )
    assert found == pytest.approx(exact(steps, -60.0 * 0.1, goals(steps), 80.0)[-1], abs=1e-7)


OSP_SYSTEM = """<?xml version="1.0" encoding="utf-8"?>
<OspSystemStructure xmlns="http://opensimulationplatform.com/MSMI/OSPSystemStructure" version="0.1">
  <BaseStepSize>0.01</BaseStepSize>
  <Algorithm>fixedStep</Algorithm>
  <Simulators>
    <Simulator name="spring" source="spring_loop_plant.fmu">
      <InitialValues>
        <InitialValue variable="k"><Real value="80"/></InitialValue>
      </InitialValues>
    </Simulator>
    <Simulator name="loop" source="spring_loop_loop.fmu"/>
  </Simulators>
  <Connections>
    <VariableGroupConnection>
      <VariableGroup simulator="spring" name="place"/>
      <VariableGroup simulator="loop" name="at"/>
    </VariableGroupConnection>
    <VariableGroupConnection>
      <VariableGroup simulator="loop" name="force"/>
      <VariableGroup simulator="spring" name="push"/>
    </VariableGroupConnection>
  </Connections>
</OspSystemStructure>
"""


def test_libcosim_connects_the_groups_of_two_fmus(tmp_path, monkeypatch):
    """A system of OSP: its connections name groups, which only the files beside the FMUs have."""
    monkeypatch.setattr(binaries, "_FLAGS", ("-std=c11", "-O0", "-fPIC", "-fvisibility=hidden"))
    for scene, name in (("plant", "push"), ("loop", "at")):
        build(tmp_path, "--target", "fmu2", "--input", name, scene=scene)
    (tmp_path / "OspSystemStructure.xml").write_text(OSP_SYSTEM)
    steps = 200

    def start(execution):
        return execution.from_osp_config_file(osp_path=str(tmp_path))

    wanted = exact(steps, -60.0 * 0.1, goals(steps), 80.0)[-1]
    assert run_by_libcosim(start, "spring", steps) == pytest.approx(wanted, abs=1e-7)
    (tmp_path / "spring_loop_loop_OspModelDescription.xml").unlink()
    with pytest.raises(AssertionError, match="extended model description for loop"):
        start(pytest.importorskip("libcosimpy.CosimExecution").CosimExecution)


def test_an_input_of_the_system(tmp_path, monkeypatch):
    monkeypatch.setattr(binaries, "_FLAGS", ("-std=c11", "-O0", "-fPIC", "-fvisibility=hidden"))
    build(tmp_path, "--input", "force")
    with ZipFile(tmp_path / "spring_loop_plant.ssp") as files:
        root = ElementTree.fromstring(files.read("SystemStructure.ssd"))
    space = "{http://ssp-standard.org/SSP1/SystemStructureDescription}"
    (wire,) = root.iter(f"{space}Connection")
    assert wire.attrib == {
        "startConnector": "force.e", "endElement": "spring_loop_plant", "endConnector": "force.e"
    }  # fmt: skip


PLANT, LOOP = "spring_loop_plant", ("--part", "loop=:loop")


@pytest.mark.parametrize(
    ("code", "arguments"),
    [
        ("BG635", ["--part", "loop"]),
        ("BG636", [*LOOP, "--connect", "loop.force"]),
        ("BG637", ["--part", f"{PLANT}=:loop"]),
        ("BG638", [*LOOP, "--connect", "lop.force -> loop.goal"]),
        ("BG638", [*LOOP, "--input", "push"]),
        ("BG639", [*LOOP, "--connect", f"loop.farce -> {PLANT}.push"]),
        ("BG640", [*LOOP, "--connect", f"{PLANT}.place -> loop.goal"]),
        ("BG080", [*LOOP, "--connect", "loop.force -> loop.gole"]),
        ("BG640", [*LOOP, "--connect", f"{PLANT}.place[1] -> loop.gain"]),
        ("BG641", [*LOOP, *(2 * ["--connect", f"loop.force -> {PLANT}.push"])]),
    ],
)  # fmt: skip
def test_refusals(tmp_path, code, arguments):
    assert code in build(tmp_path, *arguments)
    assert list(tmp_path.iterdir()) == []


def test_options_of_other_targets(tmp_path):
    result = CliRunner().invoke(application, ["build", str(MODELS), *LOOP])
    assert "--part needs --target ssp" in result.output
