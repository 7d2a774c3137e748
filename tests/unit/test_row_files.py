"""Files of rows that are written while a run goes on."""

from __future__ import annotations

import errno
import io
import json
import os
import threading
import tracemalloc
import zipfile
import zlib
from pathlib import Path

import numpy as np
import pytest
import zarr

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.model import Model
from bgc.runtime.results import kept_rows, npz_rows, row_files
from bgc.runtime.results.kept_rows import KeptRows
from bgc.runtime.results.npz_rows import NpzRows
from bgc.runtime.results.recorded_shapes import read_shapes
from bgc.runtime.results.row_files import RowArray
from bgc.runtime.running import row_stream
from bgc.runtime.running.failures import RunInterrupted, SimulationError
from bgc.runtime.running.progress import ProgressBar

ROWS = 4001


@pytest.fixture(scope="module")
def model(tmp_path_factory) -> Model:
    path = tmp_path_factory.mktemp("model") / "ball.bg"
    path.write_text(
        "model Ball { state up = 1; state fall = 0; param limit = 3;\n"
        "  der(up) = fall; der(fall) = -9.81;\n"
        "  when up < 0 { reset fall = -0.9*fall; }\n"
        '  assert time < limit, "too late"; shape sphere(0.1 + up/100) at [0, 0, up]; }\n'
        "scene s of Ball { observe up in mm; observe fall; run 2 s every 0.5 ms; }\n"
    )
    return bgc.compile(path, shapes=True)


@pytest.fixture
def growing(monkeypatch) -> None:
    """Files that grow while the run goes on, from the first thousand numbers."""
    monkeypatch.setattr(row_stream, "MOST_VALUES", 1000)
    monkeypatch.setattr(row_stream, "_FIRST", 700)
    monkeypatch.setattr(row_stream, "MOST_ROWS", 1000)


def read(path: Path) -> np.ndarray:
    """All columns of a file, time first; archives must pass their checksums."""
    if path.suffix == ".csv":
        return np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    if path.suffix == ".zarr":
        group = zarr.open_group(str(path), mode="r")
        return np.column_stack([group[name][:] for name in ("time", "up [mm]", "fall")])
    assert zipfile.ZipFile(path).testzip() is None
    with np.load(path) as arrays:
        return np.column_stack([arrays[name] for name in ("time", "up [mm]", "fall")])


KINDS = pytest.mark.parametrize("kind", ["csv", "npz", "zarr"])


@KINDS
@pytest.mark.parametrize("solver", ["rodas5p", "ros34prw"])
def test_blocks_have_the_bits_of_one_run(model, growing, tmp_path, kind, solver):
    options = {"solver": solver, "step": 0.004 if solver == "ros34prw" else None}
    whole = model.simulate(**options)
    path = tmp_path / f"rows.{kind}"
    result = model.simulate(**options, out=path)
    table = np.column_stack((whole.time, whole["up [mm]"], whole["fall"]))
    assert np.array_equal(read(path), table)
    assert (result.rows, result.row_count) == (ROWS, ROWS)
    assert result.counts["steps"] == whole.counts["steps"]


@pytest.mark.parametrize("kind", ["csv", "npz"])
def test_the_memory_of_a_run_does_not_grow_with_its_rows(
    model, growing, monkeypatch, tmp_path, kind
):
    """Ten times the rows, which would take 0.9 MB."""
    monkeypatch.setattr(kept_rows, "SELECTED_VALUES", 1000)
    peaks = []
    for every in ("1 ms", "1 ms", "0.1 ms"):  # the first run fills caches
        tracemalloc.start()
        result = model.simulate(every=every, out=tmp_path / f"rows.{kind}")
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert result.rows == 20_001
    assert peaks[2] < peaks[1] + 200_000


def test_what_an_archive_says_of_itself(model, growing, tmp_path):
    path = tmp_path / "rows.npz"
    model.simulate(out=path)
    with np.load(path) as arrays:
        about = json.loads(str(arrays["about"]))
    whole = model.simulate()
    assert about == json.loads(json.dumps(whole.about()))
    for shape, expected in zip(read_shapes(path), whole.shapes, strict=True):
        for name in ("r", "A", "radius"):
            assert np.array_equal(shape[name], expected[name])
    model.simulate(out=tmp_path / "rows.zarr")
    attributes = zarr.open_group(str(tmp_path / "rows.zarr")).attrs
    assert (attributes["status"], attributes["scene"]) == ("done", "s")


def test_a_stream_gets_csv(model, growing):
    text = io.StringIO()
    whole = model.simulate(out=text)
    assert text.getvalue().count("\n") == ROWS + 1
    assert text.getvalue().startswith("time,up [mm],fall\n0.0,1000.0,0.0\n")
    assert whole.rows == ROWS


@KINDS
def test_short_runs_keep_all_rows(model, tmp_path, kind):
    path = tmp_path / f"rows.{kind}"
    result = model.simulate(out=path)
    assert (result.rows, len(result.time)) == (0, ROWS)
    assert np.array_equal(read(path)[:, 2], result["fall"])


@pytest.mark.parametrize("most", [50, 400, 100_000])
def test_the_selection_has_the_extremes_of_all_rows(monkeypatch, most):
    rng = np.random.default_rng(1)
    monkeypatch.setattr("bgc.runtime.results.kept_rows.SELECTED_VALUES", most)
    monkeypatch.setattr("bgc.runtime.results.kept_rows._GROUPS", 20)
    rows = rng.standard_normal((5003, 3)).cumsum(axis=0)
    times = np.arange(len(rows)) * 0.1
    kept, at = KeptRows(len(rows), 3), 0
    for size in (1, 7, 1000, 3995):
        kept.add(times[at : at + size], rows[at : at + size].copy())
        at += size
    some_times, some = kept.selection()
    assert len(some) <= min(len(rows), max(4, most // 4 + 8))
    places = np.searchsorted(times, some_times)
    assert np.array_equal(rows[places], some) and np.all(np.diff(places) > 0)
    assert places[0] == 0 and places[-1] == len(rows) - 1
    if most > 50:  # enough for intervals: in each, the extremes of each column
        assert np.array_equal(some.max(axis=0), rows.max(axis=0))
        assert np.array_equal(some.min(axis=0), rows.min(axis=0))


def test_the_first_value_that_is_not_finite_is_selected(monkeypatch):
    monkeypatch.setattr("bgc.runtime.results.kept_rows.SELECTED_VALUES", 100)
    rows = np.ones((1000, 1))
    rows[333], rows[337] = np.inf, np.nan
    kept = KeptRows(1000, 1)
    kept.add(np.arange(1000.0), rows)
    times, _ = kept.selection()
    assert 333.0 in times and 999.0 in times


@KINDS
def test_a_failed_run_leaves_its_rows(model, growing, tmp_path, kind):
    path = tmp_path / f"rows.{kind}"
    with pytest.raises(SimulationError, match="BG705") as error:
        model.simulate(out=path, parameters={"limit": 1.4})
    done = error.value.result.rows
    assert 2700 < done < ROWS
    table = read(path)
    assert len(table) == done and np.isfinite(table).all()
    if kind == "npz":  # the room for rows that were never computed is given back
        assert path.stat().st_size < 8 * done * 13 + 20_000
        with np.load(path) as arrays:
            assert json.loads(str(arrays["about"]))["status"] == "failed"
        assert len(read_shapes(path)[0].r) == done


@KINDS
def test_ctrl_c_leaves_the_rows(model, growing, tmp_path, kind, monkeypatch):
    taken, shown, take = threading.Event(), threading.Event(), row_stream._Blocks._take

    def pressed(self: ProgressBar, reached: float) -> None:
        taken.wait(30)
        shown.set()
        raise KeyboardInterrupt

    def slow(self: row_stream._Blocks, times: np.ndarray, rows: np.ndarray) -> None:
        take(self, times, rows)
        taken.set()
        shown.wait(30)
        threading.Event().wait(0.01)

    monkeypatch.setattr(ProgressBar, "show", pressed)
    monkeypatch.setattr(row_stream._Blocks, "_take", slow)
    path = tmp_path / f"rows.{kind}"
    with pytest.raises(RunInterrupted) as error:
        model.simulate(out=path)
    done = error.value.result.rows
    assert 0 < done < ROWS and len(read(path)) == done


class Full(io.FileIO):
    """A file on a disk that becomes full."""

    room = 60_000

    def write(self, data) -> int:
        space = Full.room - self.tell()
        if space <= 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return super().write(memoryview(data)[:space])


def test_a_full_disk_ends_the_run_and_leaves_whole_lines(model, growing, tmp_path, monkeypatch):
    path = tmp_path / "rows.csv"
    with monkeypatch.context() as patch:
        patch.setattr(Path, "open", lambda path, *_, **__: Full(path, "w"))
        with pytest.raises(SimulationError, match=r"BG590.*No space left") as error:
            model.simulate(out=path)
    assert 500 < error.value.result.rows == len(read(path)) < ROWS
    assert path.read_bytes().endswith(b"\n")


def test_a_full_disk_leaves_an_archive(model, growing, tmp_path, monkeypatch):
    put = NpzRows._put

    def full(self: NpzRows, at: int, data: bytes) -> None:
        if self.rows > 2000 and isinstance(data, memoryview):  # what is written can be replaced
            put(self, at, data[:800])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        put(self, at, data)

    monkeypatch.setattr(NpzRows, "_put", full)
    path = tmp_path / "rows.npz"
    with pytest.raises(SimulationError, match=r"BG590.*No space left") as error:
        model.simulate(out=path)
    assert 2000 < error.value.result.rows == len(read(path)) < ROWS


def test_a_full_disk_leaves_a_group(model, growing, tmp_path, monkeypatch):
    store = zarr.Array.__setitem__

    def full(self, place, value):
        if place.start > 2000 and "fall" in self.name:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        store(self, place, value)

    monkeypatch.setattr(zarr.Array, "__setitem__", full)
    path = tmp_path / "rows.zarr"
    with pytest.raises(SimulationError, match=r"BG590.*No space left") as error:
        model.simulate(out=path)
    assert 2000 < error.value.result.rows == len(read(path)) < ROWS


def test_a_killed_process_leaves_a_readable_archive(tmp_path):
    path, copy = tmp_path / "rows.npz", tmp_path / "copy.npz"
    about = {"message": "", "names": "é"}
    file = NpzRows(
        path, [RowArray("x", "m", (), (0,)), RowArray("é", "", (2, 1), (1, 2), 2.0)], 90, about
    )
    rows = np.arange(270.0).reshape(90, 3)
    for first in (0, 40):
        file.append(rows[first : first + 40, 0], rows[first : first + 40])
        copy.write_bytes(path.read_bytes())
        assert zipfile.ZipFile(copy).testzip() is None
        with np.load(copy) as found:
            done = first + 40
            assert np.array_equal(found["x"], rows[:done, 0])
            assert np.array_equal(found["é"], rows[:done, 1:, None] / 2)
    file.end({**about, "message": "é" * 9000})
    with np.load(path) as arrays:
        assert json.loads(str(arrays["about"]))["message"].startswith("éé")


def test_checksums_join():
    for first, second in ((b"", b""), (b"abc", b""), (b"", b"abc"), (b"ab" * 99, bytes(70_001))):
        joined = npz_rows._joined_crc(zlib.crc32(first), zlib.crc32(second), len(second))
        assert joined == zlib.crc32(first + second)


def test_other_folders_are_not_replaced(model, growing, tmp_path):
    path = tmp_path / "rows.zarr"
    model.simulate(out=path)
    model.simulate(1.0, out=path)
    assert len(read(path)) == 2001
    other = tmp_path / "other.zarr"
    other.mkdir()
    (other / "mine").touch()
    with pytest.raises(BgError, match=r"BG055.*does not hold the rows of a run"):
        model.simulate(out=other)
    assert (other / "mine").exists()


@pytest.mark.parametrize(
    ("out", "code"), [("rows.xlsx", "BG070"), ("none/rows.csv", "BG055"), (".", "BG070")]
)
def test_files_that_cannot_be(model, tmp_path, monkeypatch, out, code):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BgError, match=code):
        model.simulate(out=out)


def test_more_rows_than_the_disk_holds(model, tmp_path):
    with pytest.raises(BgError, match="BG068"):
        model.simulate(1e9, every=1e-9, out=tmp_path / "rows.csv")
    assert not (tmp_path / "rows.csv").exists()


def test_an_unbuffered_file_may_take_less(tmp_path):
    class Slow(io.FileIO):
        def write(self, data) -> int:
            return super().write(memoryview(data)[:7])

    with Slow(tmp_path / "f", "w") as file:
        row_files.write_all(file, bytes(range(100)))
    assert (tmp_path / "f").read_bytes() == bytes(range(100))
