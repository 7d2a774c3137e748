"""Data files: what is read, and what is refused with its reason."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest
from refusals import refusal

from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.source import Source, Span
from bgc.driver import check_source
from bgc.values import data_files
from bgc.values.data_files import Numbers, read_data
from bgc.values.units import parse_unit

SPAN = Span(Source("<test>", ""), 0, 0)


def read(folder: Path, content: str | bytes, name: str = "d.csv") -> data_files.DataFile:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return read_data(path, name, SPAN)


def reason(folder: Path, content: str | bytes, name: str = "d.csv") -> str:
    diagnostic = refusal(read, folder, content, name)
    assert diagnostic.help
    return f"{diagnostic.code} {diagnostic.message}"


def columns(file: data_files.DataFile) -> dict[str, list[float]]:
    return {k: v.array.tolist() for k, v in file.entries.items() if isinstance(v, Numbers)}


@pytest.mark.parametrize(
    "text",
    [
        "a,b c\n1,2.5\n3,-4e-1\n",
        "a,b c\r\n1,2.5\r\n3,-4e-1\r\n",
        "\ufeffa;b c\n1;2.5\n3;-4e-1",
        'a\t"b c"\n1\t2.5\n\n3\t-.4\n\n',
        " a , b c \n 1 , 2.5 \n 3 , -0.4 \n",
    ],
)
def test_tables_in_several_spellings(text: str, tmp_path) -> None:
    assert columns(read(tmp_path, text)) == {"a": [1, 3], "b c": [2.5, -0.4]}


def test_units_are_converted_to_si(tmp_path) -> None:
    file = read(tmp_path, "t [ms],F[kN],angle [deg]\n5,2,180\n")
    found = {k: (v.array[0], v.unit) for k, v in file.entries.items() if isinstance(v, Numbers)}
    assert found["t"] == (0.005, parse_unit("s").dimension)  # type: ignore[union-attr]
    assert found["F"] == (2000, parse_unit("N").dimension)  # type: ignore[union-attr]
    assert found["angle"][0] == pytest.approx(np.pi, rel=1e-15)


def test_json_gives_values_by_key(tmp_path) -> None:
    content = {
        "mass [t]": 8,
        "note": "a text",
        "none": None,
        "hull": {"M": [[1, 2], [3, 4.5]], "r [mm]": [1, 2, 3], "deep": {"x": 0.1}},
    }
    entries = read(tmp_path, json.dumps(content), "s.json").entries
    assert list(entries) == ["mass", "hull"]
    hull = entries["hull"]
    assert isinstance(hull, dict) and isinstance(entries["mass"], Numbers)
    assert entries["mass"].array == 8000
    assert hull["M"].array.tolist() == [[1, 2], [3, 4.5]]  # type: ignore[union-attr]
    assert hull["r"].array.tolist() == [0.001, 0.002, 0.003]  # type: ignore[union-attr]
    assert hull["deep"]["x"].name == "hull.deep.x"  # type: ignore[index, union-attr]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("a,b\n1,2\n3\n", "line 3 has 1 value, the header 2"),
        ("a,b\n1,2\n3,4,5\n", "line 3 has 3 values, the header 2"),
        ("a,b\n1,2,3\n4,5,6\n", "line 2 has 3 values, the header 2"),
        ("a,b\n1,\n", "line 2 has nothing in column `b`"),
        ("a,b\n1,inf\n", "line 2 has no finite number in column `b`"),
        ("a,b\n1,secret\n", "line 2 has no finite number in column `b`"),
        ("a;b\n1;2,5\n", "line 2 has no finite number in column `b`"),
        ("a,a\n1,2\n", "column 2 has the name `a` again in line 1"),
        ("a,\n1,2\n", "column 2 has no name in line 1"),
        ("a,b\n \n\n", "it has no rows of numbers"),
        ("", "column 1 has no name in line 1"),
        ("a,b\x1b[2J\n1,2\n", "a title has control characters"),
    ],
)
def test_malformed_tables(text: str, why: str, tmp_path) -> None:
    found = reason(tmp_path, text)
    assert found.startswith("BG251") and why in found and "secret" not in found


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("[1, 2]", "it is not an object"),
        ('{"a": 1,}', "line 1, column"),
        ('{"a": [1, [2]]}', "`a` is neither a number"),
        ('{"a": {"b": [1, "x"]}}', "`a.b` is neither a number"),
        ('{"a": NaN}', "`a` is neither a number"),
        ('{"a": []}', "`a` is neither a number"),
        ('{"a": [[[1]]]}', "`a` is neither a number"),
        ('{"a": 1, "a [m]": 2}', "`a` is there twice"),
        ('{"a": ' + "[" * 100_000, "nested too deeply"),
        ('{"a": 1' + "0" * 5000 + "}", ""),
    ],
)
def test_malformed_values(text: str, why: str, tmp_path) -> None:
    found = reason(tmp_path, text, "s.json")
    assert found.startswith("BG251") and why in found


def test_files_that_cannot_be_read(tmp_path, monkeypatch) -> None:
    assert "0xF6" in reason(tmp_path, b"a,h\xf6he\n1,2\n")
    assert "`.csv` nor `.json`" in reason(tmp_path, "a\n1\n", "d.txt")
    (tmp_path / "folder.csv").mkdir()
    os.mkfifo(tmp_path / "pipe.csv")
    for name, why in (("folder", "not a file"), ("pipe", "not a file"), ("none", "no such file")):
        with pytest.raises(BgError, match=why):
            read_data(tmp_path / f"{name}.csv", f"{name}.csv", SPAN)
    with pytest.raises(BgError, match="BG250"):
        read_data(Path("a\0.csv"), "a", SPAN)
    monkeypatch.setattr(data_files, "MAX_BYTES", 10)
    assert "more than 10 bytes" in reason(tmp_path, "a\n" + "1\n" * 10)


def test_long_columns_are_tables_only(tmp_path) -> None:
    (tmp_path / "long.csv").write_text("t,z\n" + "".join(f"{k},{k % 7}\n" for k in range(10_001)))
    model = """
const long = data("long.csv");
const z = long.z;
function at(x, y) = interpolate(long.t, y, x);
model Reads {{
  state x = 0;
  der(x) = at(time, z) + long.z[length(z)] + sum(long.z[1..100]);
  output all = {all};
}}
scene s of Reads {{ observe x, all; run 1; }}
"""
    path = tmp_path / "m.bg"
    path.write_text(model.format(all="length(long.t)"))
    assert check_source(path) == []
    path.write_text(model.format(all="sum(long.z)"))
    (diagnostic,) = check_source(path)
    assert diagnostic.code == "BG254"
