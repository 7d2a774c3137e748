"""FMUs of library scenes with devices, and the folders of binaries."""

from pathlib import Path

import numpy as np
from fmpy.validation import validate_fmu

from bgc.runtime.fmi import binaries
from bgc.runtime.fmi.binaries import binary_folders, read_platforms


def test_a_library_scene_replays_its_device_in_fmi_3(tmp_path, monkeypatch):
    """The road comes from a trace: the FMU gets what the driver gave at each sample.

    By the functions of `tests/bench/fmus.py`, which goes through all scenes of the library.
    """
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1] / "bench"))
    import fmus

    monkeypatch.setattr(binaries, "_FLAGS", ("-std=c11", "-O0", "-fPIC", "-fvisibility=hidden"))
    path = fmus.LIBRARY / "examples" / "quarter_car.bg"
    run = fmus.native(path, "on_track")
    fmu, table, columns, residual = fmus.exported(path, "on_track", 3, tmp_path / "fmu")
    assert validate_fmu(str(fmu)) == []
    unit = fmus.unit_of(fmu, table, tmp_path / "unpacked", run)
    assert run.period == 1e-3 and np.ptp(run.fed) > 0.01
    found, wanted = unit.rows(run.times[:301]), run.rows[:301, columns]
    assert fmus.differences(found, wanted, residual).max() < 1e-9
    assert unit.rolls_back(run.times[:61])


def test_binaries_lie_where_importers_look_for_them():
    two, three = (
        [*binary_folders(read_platforms(names), version).values()]
        for names, version in (("linux64,linux-aarch64,darwin-aarch64,win64", 2), ("win64", 3))
    )
    assert two == ["linux64", "win64", "aarch64-linux", "darwin64"] and three == ["x86_64-windows"]
