import csv
import json
import os
import stat
import sys
from dataclasses import replace

import numpy as np
import pytest
from refusals import code_of, refusal

from bgc.diagnostics.diagnostic import BgError
from bgc.language.scene import Plot
from bgc.runtime.results.columns import UnknownColumn
from bgc.runtime.results.plot import read_panel
from bgc.runtime.results.result import Result

TIME = np.array([0.0, 0.1, 0.2])


def make(names: dict[str, str], time: np.ndarray = TIME) -> Result:
    return Result(
        scene="s",
        time=time,
        columns={name: (k + 1) * time / 3 for k, name in enumerate(names)},
        units=names,
        solver="rodas5p",
        counts={},
    )


@pytest.fixture
def result() -> Result:
    return make({"tip[2]": "m", "tip[1]": "m", "force": "N", "tip.z": "m"})


# --- columns --------------------------------------------------------------------------------


def test_columns_by_name(result):
    assert result["force"].tolist() == (3 * TIME / 3).tolist()
    assert result["time"] is result.time
    assert list(result) == ["tip[2]", "tip[1]", "force", "tip.z"]
    assert "tip" in result and "time" in result and "tap" not in result


def test_vectors_in_the_order_of_their_components(result):
    assert np.array_equal(result["tip"], np.column_stack([result["tip[1]"], result["tip[2]"]]))


def test_a_component_by_the_name_of_its_axis(result):
    assert result["tip.x"] is result["tip[1]"]
    assert "tip.y" in result and "force.x" not in result
    assert result.expand(["tip.y", "tip.z"]) == ["tip[2]", "tip.z"]  # `tip.z` has its own column


def test_a_column_in_a_unit_is_found_by_the_name_of_the_quantity():
    result = make({"bore [bar]": "bar", "tip[2] [mm]": "mm", "tip[1] [mm]": "mm", "tip": "m"})
    assert result["bore"] is result["bore [bar]"] and "bore" in result
    assert result["tip"] is result.columns["tip"]  # a column of that name comes first
    assert np.array_equal(result["tip [mm]"][:, 0], result["tip.x"])
    assert result.expand(["bore", "tip.y"]) == ["bore [bar]", "tip[2] [mm]"]


def test_a_name_with_several_units_is_refused():
    result = make({"q [mm]": "mm", "q [cm]": "cm", "p": "m"})
    assert "q" not in result and "q [cm]" in result
    with pytest.raises(UnknownColumn) as error:
        result["q"]
    assert error.value.diagnostics[0].help == "write it with its unit: `q [mm]` and `q [cm]`"
    with pytest.raises(UnknownColumn, match="did you mean `bore`"):
        make({"bore [bar]": "bar"})["boer"]


def test_a_matrix_has_its_shape():
    places = [(i, j) for i in (2, 1) for j in (3, 1, 2)]
    columns = {f"R[{i},{j}]": 10 * i + j + TIME for i, j in places}
    result = replace(make(dict.fromkeys(columns, "1")), columns=columns)
    expected = np.array([[11, 12, 13], [21, 22, 23]]) + TIME[:, None, None]
    assert np.array_equal(result["R"], expected)
    assert result.expand(["R"])[:2] == ["R[1,1]", "R[1,2]"]
    del columns["R[2,2]"]
    assert "R" not in replace(result, columns=columns)  # one entry is not observed


def test_a_result_equals_itself_alone(result):
    assert result == result and result != replace(result) and len({result, result}) == 1


def test_unknown_columns_are_key_errors_that_suggest(result):
    with pytest.raises(UnknownColumn) as error:
        result["fource"]
    assert code_of(error) == "BG065"
    assert "`force`" in error.value.diagnostics[0].help
    assert isinstance(error.value, KeyError)
    assert str(error.value).startswith("BG065: the result has no column `fource`")
    with pytest.raises(UnknownColumn) as error:
        result[0]
    assert '["tip[2]"][k]' in error.value.diagnostics[0].help


# --- files ----------------------------------------------------------------------------------


def test_csv_has_the_contracts_header_and_every_digit(result, tmp_path):
    result.to_csv(tmp_path / "r.csv")
    lines = (tmp_path / "r.csv").read_text().splitlines()
    assert lines[0] == "time,tip[2],tip[1],force,tip.z"
    table = np.loadtxt(tmp_path / "r.csv", delimiter=",", skiprows=1)
    assert np.array_equal(table[:, 0], TIME)
    assert np.array_equal(table[:, 3], result["force"])


def test_csv_quotes_names_with_commas(tmp_path):
    make({"K[1,2]": "N"}).to_csv(tmp_path / "r.csv")
    with (tmp_path / "r.csv").open(newline="") as file:
        assert next(csv.reader(file)) == ["time", "K[1,2]"]


def test_a_failed_write_leaves_the_earlier_file(result, tmp_path, monkeypatch):
    target = tmp_path / "r.csv"
    target.write_text("earlier")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Result, "write_csv", full)
    assert refusal(result.to_csv, target).code == "BG055"
    assert target.read_text() == "earlier"
    assert [path.name for path in tmp_path.iterdir()] == ["r.csv"]


def test_writing_into_a_missing_folder_is_a_diagnostic(result, tmp_path):
    assert refusal(result.to_csv, tmp_path / "missing" / "r.csv").code == "BG055"


@pytest.mark.skipif(sys.platform == "win32", reason="no such permissions")
def test_files_get_the_users_permissions_and_keep_their_own(result, tmp_path):
    old = os.umask(0o027)
    try:
        result.to_csv(tmp_path / "new.csv")
        (tmp_path / "own.csv").touch(mode=0o600)
        result.to_csv(tmp_path / "own.csv")
    finally:
        os.umask(old)
    assert stat.S_IMODE((tmp_path / "new.csv").stat().st_mode) == 0o640
    assert stat.S_IMODE((tmp_path / "own.csv").stat().st_mode) == 0o600


def test_writing_through_a_link_keeps_the_link(result, tmp_path):
    (tmp_path / "link.csv").symlink_to(tmp_path / "real.csv")
    result.to_csv(tmp_path / "link.csv")
    assert (tmp_path / "link.csv").is_symlink()
    assert (tmp_path / "real.csv").read_text().startswith("time,")


def test_npz_holds_columns_and_units(tmp_path):
    result = make({"tip[1]": "m", "file": ""})
    result.to_npz(tmp_path / "r.npz")
    with np.load(tmp_path / "r.npz") as archive:
        assert sorted(archive) == ["about", "file", "time", "tip[1]"]
        assert np.array_equal(archive["tip[1]"], result["tip[1]"])
        about = json.loads(str(archive["about"]))
    assert about["units"] == {"time": "s", "tip[1]": "m", "file": ""}
    assert about["status"] == "done"


def test_pandas_frame_is_indexed_by_time(result):
    pytest.importorskip("pandas")
    frame = result.to_pandas()
    assert frame.index.name == "time"
    assert list(frame.columns) == list(result)
    assert frame.attrs["units"]["force"] == "N"


def test_without_pandas_the_message_says_what_to_install(result, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(BgError) as error:
        result.to_pandas()
    assert code_of(error) == "BG058"
    assert "pip install pandas" in error.value.diagnostics[0].help


# --- plots ------------------------------------------------------------------------------------


def test_columns_are_stacked_by_unit(result):
    figure = result.plot()
    assert [axes.get_ylabel() for axes in figure.axes] == ["[m]", "force [N]"]
    assert [len(axes.lines) for axes in figure.axes] == [3, 1]
    assert figure.axes[-1].get_xlabel() == "time [s]"


def test_panels_against_time_and_against_another_column(result):
    figure = result.plot(panels=["tip.z, force", "force against tip.z"])
    first, second, right = figure.axes[0], figure.axes[2], figure.axes[1]
    assert (first.get_ylabel(), right.get_ylabel()) == ("tip.z [m]", "force [N]")
    assert (second.get_xlabel(), second.get_ylabel()) == ("tip.z [m]", "force [N]")


def test_long_numbers_have_their_factor_in_the_label():
    """D11: matplotlib's factor stood over the legend."""
    result = make({"p": "Pa", "x": "m", "d": "m"})
    result.columns["p"] = np.array([1e7, 2e7, 3e7])
    result.columns["d"] = np.array([1e-6, 2e-6, 3e-6])
    figure = result.plot(panels=["p", "x", "d", "d against p"])
    pressure, plain, small, across = figure.axes
    assert pressure.get_ylabel() == "p [$10^{6}$ Pa]"
    assert plain.get_ylabel() == "x [m]"
    assert small.get_ylabel() == "d [$10^{-6}$ m]"
    assert across.get_xlabel() == "p [$10^{6}$ Pa]"
    figure.canvas.draw()
    ticks = [float(label.get_text()) for label in pressure.get_yticklabels()]
    assert ticks == pytest.approx(np.array(pressure.get_yticks()) / 1e6)
    assert all(not axes.yaxis.get_offset_text().get_text() for axes in figure.axes)


def test_two_scales_have_the_colours_of_their_curves():
    result = make({"x": "m", "v": "m/s"})
    left, right = result.plot(panels=["x, v"]).axes
    for axes in (left, right):
        assert axes.yaxis.label.get_color() == axes.lines[0].get_color()
    assert left.lines[0].get_color() != right.lines[0].get_color()


def test_one_component_against_another(result):
    (axes,) = result.plot(panels=["tip.y against tip.x"]).axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("tip[1] [m]", "tip[2] [m]")
    assert refusal(result.plot, panels=["tip.y against tip"]).code == "BG069"


def test_the_scenes_panels_are_the_default(result):
    scene = (Plot(("force",), "tip.z"), Plot(("tip",)))
    result = replace(result, panels=scene)
    first, second = result.plot().axes
    assert (first.get_xlabel(), first.get_ylabel()) == ("tip.z [m]", "force [N]")
    assert [line.get_label() for line in second.lines] == ["tip[1]", "tip[2]"]
    assert len(result.plot(columns=["force"]).axes) == 1


def test_a_vector_is_plotted_by_its_components(result):
    (axes,) = result.plot(columns=["tip"]).axes
    assert [line.get_label() for line in axes.lines] == ["tip[1]", "tip[2]"]


@pytest.mark.parametrize("kind", ["png", "svg", "pdf"])
def test_plots_are_written(result, tmp_path, kind):
    result.plot(tmp_path / f"r.{kind}")
    assert (tmp_path / f"r.{kind}").stat().st_size > 1000


def test_errors_are_a_band_where_it_is_wider_than_a_curve(result):
    known = replace(result, errors={"force": np.full(3, 1e-4), "tip.z": np.full(3, 0.03)})
    figure = known.plot(columns=["force", "tip.z"])
    first, second = figure.axes
    assert not first.collections and figure.get_supxlabel() == "band: estimated error"
    (band,) = second.collections
    (outline,) = band.get_paths()
    top = outline.vertices[:, 1].max()
    assert top == pytest.approx(result["tip.z"].max() + 0.03)
    # Columns without an estimate have none, and those of which it is unknown are named.
    unknown = replace(result, errors={"force": np.full(3, np.nan)})
    figure = unknown.plot(columns=["force", "tip.z"])
    assert not any(axes.collections for axes in figure.axes)
    assert figure.get_supxlabel() == "error unknown: force"
    assert result.plot().get_supxlabel() == ""


def test_errors_are_a_result_of_the_same_columns(result):
    error = replace(result, errors={"tip[1]": TIME}).error
    assert list(error) == list(result) and error["tip"][:, 0].tolist() == TIME.tolist()
    assert np.isnan(error["force"]).all() and error.units == result.units


def test_the_same_result_draws_the_same_bytes(result, tmp_path):
    for name in ("a.svg", "b.svg"):
        result.plot(tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


@pytest.mark.parametrize(
    ("text", "panel"),
    [
        ("a, b.c", Plot(("a", "b.c"))),
        ("K[1,2],x", Plot(("K[1,2]", "x"))),
        ("y against x", Plot(("y",), "x")),
    ],
)
def test_panels_are_read(text, panel):
    assert read_panel(text) == panel


@pytest.mark.parametrize("text", ["", "a,", "a against ", " against b"])
def test_what_is_no_panel(text):
    assert refusal(read_panel, text).code == "BG069"


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        ({"path": "r.bmp"}, "BG070"),
        ({"columns": ["nothing"]}, "BG065"),
        ({"panels": ["force against nothing"]}, "BG065"),
    ],
)
def test_what_cannot_be_plotted(result, arguments, code):
    assert refusal(result.plot, **arguments).code == code


def test_a_result_without_columns_or_rows_has_nothing_to_plot(result):
    for empty in (make({}), make({"a": ""}, TIME[:1])):
        assert refusal(empty.plot).code == "BG075"
