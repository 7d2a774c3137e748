"""Models with data files: recorded roads, characteristics, ensembles, linear forms, caches."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from model_files import compiled, model_text
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline, PchipInterpolator
from scipy.linalg import expm

import bgc
from bgc.diagnostics.diagnostic import BgError

CAR = model_text("data_car")
MATRIX = np.array(
    [
        [0, 0, 1, 0],
        [0, 0, 0, 1],
        [-200e3 / 40, 20e3 / 40, -1500 / 40, 1500 / 40],
        [20e3 / 300, -20e3 / 300, 1500 / 300, -1500 / 300],
    ]
)
FORCE = np.array([0, 0, 180e3 / 40, 0])


def recorded(folder: Path, count: int = 200) -> tuple[np.ndarray, np.ndarray]:
    """A rough road of 4 m in uneven steps, written in mm."""
    rng = np.random.default_rng(4)
    s = np.round(np.cumsum(rng.uniform(0.005, 0.035, count)), 4)
    s *= 4.0 / s[-1]
    z = np.round(np.cumsum(rng.normal(size=count)) * 2, 3)
    rows = "".join(f"{a!r},{b!r}\n" for a, b in zip(s.tolist(), z.tolist(), strict=True))
    (folder / "road.csv").write_text(f"s pos,z [mm]\n{rows}")
    return s, z / 1000


def model_of(folder: Path, text: str = CAR, **replaced: str) -> bgc.Model:
    for name, value in replaced.items():
        text = text.replace(name, value)
    return compiled(folder, text)


def exact_ride(s: np.ndarray, z: np.ndarray, speed: float, at: np.ndarray) -> np.ndarray:
    """The ride over a road of straight lines, by the exponential of a matrix on each of them."""
    knots = np.concatenate(([0.0], s / speed, [1e9]))
    heights = np.concatenate((z[:1], z, z[-1:]))
    slopes = np.diff(heights) / np.diff(knots)
    state, now, rows = np.zeros(4), 0.0, []
    for k, end in enumerate(knots[1:]):
        stops = [t for t in at if now < t <= end or (t == 0 and k == 0)]
        for t in [*stops, end] if end < at[-1] else stops:
            whole = np.zeros((6, 6))
            whole[:4, :4], whole[:4, 4], whole[4, 5] = MATRIX, FORCE, 1.0
            start = heights[k] + slopes[k] * (now - knots[k])
            state = (expm(whole * (t - now)) @ np.concatenate((state, [start, slopes[k]])))[:4]
            now = t
            if t in stops:
                rows.append(state)
    return np.array(rows)


@pytest.mark.parametrize("where", ["speed*time", "place"])
def test_ride_over_straight_lines_is_that_of_matrix_exponentials(where: str, tmp_path) -> None:
    s, z = recorded(tmp_path)
    model = model_of(tmp_path, WHERE=where, OPTIONS="method = linear")
    result = model.simulate(rtol=1e-9, atol=1e-12)
    exact = exact_ride(s, z, 1.3, result.time)
    np.testing.assert_allclose(result["zu"], exact[:, 0], atol=2e-10)
    np.testing.assert_allclose(result["zs"], exact[:, 1], atol=2e-10)
    coarse = model.simulate(rtol=1e-4)
    np.testing.assert_allclose(coarse["zs"], exact[:, 1], atol=2e-5)


@pytest.mark.parametrize("method", ["pchip", "spline"])
def test_ride_over_a_smooth_road_is_that_of_scipy(method: str, tmp_path) -> None:
    s, z = recorded(tmp_path, 40)
    function = PchipInterpolator(s, z) if method == "pchip" else CubicSpline(s, z)
    model = model_of(tmp_path, WHERE="speed*time", OPTIONS=f"method = {method}")
    result = model.simulate(rtol=1e-9, atol=1e-13)

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        return MATRIX @ x + FORCE * function(np.clip(1.3 * t, s[0], s[-1]))

    state, now, found = np.zeros(4), 0.0, {}
    for end in sorted({*(s / 1.3), *result.time[1:]}):
        if end > result.time[-1]:
            break
        piece = solve_ivp(rates, (now, end), state, "DOP853", rtol=1e-12, atol=1e-15)
        state, now = piece.y[:, -1], end
        found[end] = state
    exact = np.array([found[t] for t in result.time[1:]])
    np.testing.assert_allclose(result["zu"][1:], exact[:, 0], atol=1e-9)


def test_pulse_between_long_rests_is_not_missed(tmp_path) -> None:
    """A pulse of 2 ms in 100 s: cubic tables of time have bounds that steps respect."""
    t = [0, 50, 50.001, 50.002, 50.003, 100]
    y = [0, 0, 1000, 1000, 0, 0]
    rows = "".join(f"{a},{b}\n" for a, b in zip(t, y, strict=True))
    (tmp_path / "pulse.csv").write_text("t [s],y\n" + rows)
    text = """
const pulse = data("pulse.csv");
model Sum {
  state x = 0;
  state z = 0;
  der(x) = interpolate(pulse.t, pulse.y, time, method = METHOD)/(1 s);
  der(z) = -z;
}
scene s of Sum { observe x; run 100; }
"""
    for method in ("linear", "pchip", "nearest"):
        model = model_of(tmp_path, text, METHOD=method)
        found = model.simulate(rtol=1e-6)["x"][-1]
        exact = PchipInterpolator(t, y).integrate(0, 100) if method == "pchip" else 2.0
        assert found == pytest.approx(exact, rel=1e-5)


CHARACTERISTIC = model_text("data_characteristic")
VALVE = "level,flow\n0,0\n0.5,0.1\n1,0.4\n1.5,0.6\n2,1.5\n"


@pytest.mark.parametrize("method", ["linear", "pchip", "nearest"])
def test_ensembles_run_as_single_runs_do(method: str, tmp_path) -> None:
    (tmp_path / "valve.csv").write_text(VALVE)
    model = model_of(tmp_path, CHARACTERISTIC, OPTIONS=f"method = {method}")
    starts = np.linspace(0.2, 2.4, 7)
    many = model.simulate_many({"start": starts}, rtol=1e-8)
    for k, start in enumerate(starts):
        alone = model.simulate(parameters={"start": float(start)}, rtol=1e-8)
        for name in ("level", "slope", "two"):
            np.testing.assert_allclose(many[name][k], alone[name], rtol=1e-5, atol=1e-6)


def test_linear_form_has_the_slope_of_the_data(tmp_path) -> None:
    (tmp_path / "valve.csv").write_text(VALVE)
    model = model_of(tmp_path, CHARACTERISTIC, OPTIONS="method = spline")
    x, y = np.loadtxt(tmp_path / "valve.csv", delimiter=",", skiprows=1).T
    slope = CubicSpline(x, y)(1.2, 1)
    form = model.linearise(outputs=["out_flow"], state=[1.2])
    assert form.A[0, 0] == pytest.approx(slope, rel=1e-12)
    assert form.C[0, 0] == pytest.approx(slope, rel=1e-12)
    assert model.simulate(1e-6, parameters={"start": 1.2})["slope"][0] == pytest.approx(slope)


def test_leaving_the_data_is_an_error_where_asked_for(tmp_path) -> None:
    (tmp_path / "valve.csv").write_text(VALVE)
    model = model_of(tmp_path, CHARACTERISTIC, OPTIONS="outside = error")
    model.simulate(0.1, parameters={"start": 1.0})
    with pytest.raises(BgError) as caught:
        model.simulate(0.1, parameters={"start": 2.5})
    text = str(caught.value)
    assert "outside the data `flow`" in text and "from 0 to 2" in text


# --- files --------------------------------------------------------------------------------------


def test_other_data_give_another_build_and_the_same_ones_a_warm_start(tmp_path) -> None:
    (tmp_path / "valve.csv").write_text(VALVE)
    first = model_of(tmp_path, CHARACTERISTIC, OPTIONS="method = linear")
    before = first.simulate()["level"][-1]
    again = bgc.compile(tmp_path / "m.bg")
    assert again.warm and again.simulate()["level"][-1] == before
    (tmp_path / "valve.csv").write_text(VALVE.replace("2,1.5", "2,1.9"))
    other = bgc.compile(tmp_path / "m.bg")
    assert not other.warm and other.simulate()["level"][-1] != before


def test_paths_are_relative_to_the_file_that_names_them(tmp_path, monkeypatch) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "valve.csv").write_text(VALVE)
    (tmp_path / "own.json").write_text('{"x": [0, 1], "inner": {"y [mm]": [0, 500]}}')
    (tmp_path / "parts" / "tank.bg").write_text("""
model Tank {
  const table = data("valve.csv");
  state level = 1;
  der(level) = -interpolate(table["level"], table.flow, level);
  output first = table.flow[2];
}
""")
    (tmp_path / "model.bg").write_text("""
import "parts/tank.bg";
const own = data("own.json");
model World {
  const curve = own.inner;
  plain : Tank;
  state x = 0;
  der(x) = interpolate(own.x, curve.y, time)/(1 m);
}
scene s of World { observe plain.level, x, plain.first; run 1; }
""")
    monkeypatch.chdir(tmp_path.parent)
    result = bgc.compile(tmp_path / "model.bg").simulate(rtol=1e-8)
    assert result["x"][-1] == pytest.approx(0.25, rel=1e-6)
    assert result["plain.first"][-1] == 0.1


@pytest.mark.slow
def test_emitted_c_stands_alone_with_its_data(tmp_path) -> None:
    recorded(tmp_path, 2000)
    model_of(tmp_path, WHERE="speed*time", OPTIONS="method = pchip")
    command = ["bgc", "build", "m.bg", "--target", "c", "-o", "out"]
    subprocess.run(command, cwd=tmp_path, check=True)
    (tmp_path / "road.csv").unlink()
    (source,) = (tmp_path / "out").glob("*.c")
    compiler = shutil.which("cc") or "gcc"
    subprocess.run(
        [compiler, "-std=c11", "-O1", "-fPIC", "-shared", source.name, "-o", "m.so", "-lm"],
        cwd=tmp_path / "out",
        check=True,
    )
    assert b"bgc_model_table_0" in (tmp_path / "out" / "m.so").read_bytes()
    assert ".bin" not in source.read_text()


@pytest.mark.slow
def test_a_million_rows_are_one_table(tmp_path) -> None:
    """The graph has a few nodes more, and the run is that of the same road in fewer rows."""
    count = 1_000_000
    s = np.arange(count) * 4e-6
    z = np.round(1000 * 0.02 * np.sin(9 * s), 9)
    np.savetxt(
        tmp_path / "road.csv",
        np.stack((s, z), axis=1),
        "%.9f",
        ",",
        header="s pos,z [mm]",
        comments="",
    )
    model = model_of(tmp_path, WHERE="speed*time", OPTIONS="method = spline")
    result = model.simulate(rtol=1e-6)
    heights = 0.02 * np.sin(9 * 1.3 * result.time)
    np.testing.assert_allclose(result["height"], heights, atol=1e-8)
