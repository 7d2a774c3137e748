"""The Python mirror of `bgc.h` is what the header says: layouts, statuses and signatures."""

from __future__ import annotations

import ctypes
import re
import subprocess
from ctypes import c_char_p, c_double, c_int, c_size_t, c_void_p
from pathlib import Path
from typing import Any

import pytest
from method_rows import MethodStruct

from bgc.building.build import runtime_directory
from bgc.building.toolchain import find_toolchain
from bgc.runtime.running import binding, structures

HEADER = (runtime_directory() / "bgc.h").read_text("utf-8")
STRUCTURES: dict[str, Any] = {
    "bgc_param_info": structures.ParamInfo,
    "bgc_var_info": structures.VarInfo,
    "bgc_channel_use": structures.ChannelUse,
    "bgc_device_info": structures.DeviceInfo,
    "bgc_switch_info": structures.SwitchInfo,
    "bgc_method_info": MethodStruct,
    "bgc_options": structures.OptionsStruct,
    "bgc_counts": structures.CountsStruct,
    "bgc_model": structures.ModelStruct,
}
PART = {"bgc_model"}  # its last functions are not mirrored
SIZES = {c_int: "int", c_size_t: "size_t", c_double: "double", None: "void"}


def header_layout(tmp_path: Path) -> list[str]:
    """Name, offset and size of all fields by a C program, and the sizes of structs."""
    lines = [
        f'printf("{name}.{field} %zu %zu\\n", offsetof({name}, {field}), '
        f"sizeof((({name} *)0)->{field}));"
        for name, structure in STRUCTURES.items()
        for field, _ in structure._fields_
    ]
    lines += [f'printf("{name} %zu\\n", sizeof({name}));' for name in STRUCTURES.keys() - PART]
    main = '#include "bgc.h"\n#include <stdio.h>\nint main(void) {\n' + "\n".join(lines) + "\n}\n"
    (tmp_path / "layout.c").write_text(main)
    arguments = ("-std=c11", f"-I{runtime_directory()}", "layout.c", "-o", "layout")
    done = find_toolchain().run(arguments, tmp_path)
    assert done.returncode == 0, done.stdout
    out = subprocess.run([str(tmp_path / "layout")], capture_output=True, text=True, check=True)
    return out.stdout.splitlines()


def test_layout_of_structures(tmp_path: Path) -> None:
    found = [
        f"{name}.{field} {getattr(structure, field).offset} {getattr(structure, field).size}"
        for name, structure in STRUCTURES.items()
        for field, _ in structure._fields_
    ]
    found += [f"{name} {ctypes.sizeof(STRUCTURES[name])}" for name in STRUCTURES.keys() - PART]
    assert sorted(header_layout(tmp_path)) == sorted(found)


def test_statuses_and_version() -> None:
    body = re.search(r"typedef enum \{(.*?)\} bgc_status;", HEADER, re.DOTALL)
    assert body is not None
    names = re.findall(r"\bBGC_(\w+)", re.sub(r"/\*.*?\*/", "", body[1], flags=re.DOTALL))
    assert [(status.name, status.value) for status in structures.Status] == [
        (name, value) for value, name in enumerate(names)
    ]
    assert f"#define BGC_ABI {structures.ABI}\n" in HEADER


def kind_of(c_type: str) -> str:
    """The C type of an argument or a result, pointers of all sorts alike."""
    words = re.sub(r"\bconst\b|\bstruct\b", "", c_type)
    if "*" in words or "[" in words:
        return "pointer"
    (word, *_) = words.split()
    return "int" if word == "bgc_status" else word


def kind(mirrored: Any) -> str:
    is_pointer = mirrored in (c_char_p, c_void_p) or hasattr(mirrored, "contents")
    return "pointer" if is_pointer else SIZES[mirrored]


@pytest.mark.parametrize("name", [*binding._ON_INSTANCE, *binding._OTHERS])
def test_signature(name: str) -> None:
    text = re.sub(r"/\*.*?\*/", "", HEADER, flags=re.DOTALL)
    declared = re.search(rf"^([\w *]+?\*?)\b{name}\(([^)]*)\);", text, re.MULTILINE)
    assert declared is not None, f"bgc.h does not declare {name}"
    arguments = [] if declared[2] == "void" else [kind_of(a) for a in declared[2].split(",")]
    if name in binding._ON_INSTANCE:
        result, rest = binding._ON_INSTANCE[name]
        mirrored = ["pointer", "pointer", *map(kind, rest)]
    else:
        result, rest = binding._OTHERS[name]
        mirrored = list(map(kind, rest))
    assert (kind_of(declared[1]), arguments) == (kind(result), mirrored)
