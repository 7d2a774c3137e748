"""Write an FMU: a zip archive of description, binaries, sources and pictures."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from bgc.printing.draw import lay_out, to_dot
from bgc.runtime.fmi.binaries import Platform, binary_folders, build_binaries
from bgc.runtime.fmi.companions import osp_description, reference_files
from bgc.runtime.fmi.description import (
    build_description,
    fmi2_description,
    fmi3_description,
    terminals_and_icons,
)
from bgc.runtime.fmi.model import FmuModel
from bgc.runtime.results.files import written_whole

_EARLIEST = (1980, 1, 1, 0, 0, 0)  # of a zip archive: equal models make equal archives


def write_fmu(
    model: FmuModel, platforms: Sequence[Platform], folder: Path, reference: bool = False
) -> tuple[Path, ...]:
    """Write an FMU to a folder, and the files beside it; return their paths.

    An FMU of FMI 2 has its groups of variables for OSP beside it; with `reference` the files of a
    cross-check are written too. Each file is written whole or not at all.

    Raises BgError: BG055 where a file cannot be written, BG751 and BG752 where a platform does not
    build; then nothing is written.
    """
    entries = _entries(model, platforms)
    texts = {"_OspModelDescription.xml": osp_description(model)} if model.version == 2 else {}
    texts |= reference_files(model) if reference else {}
    name = model.description.identifier
    goals = [folder / f"{name}.fmu"]
    with written_whole(goals[0]) as aside:
        write_archive(aside, entries)
    for ending, text in texts.items():
        goals.append(folder / f"{name}{ending}")
        with written_whole(goals[-1]) as aside:
            aside.write_text(text, encoding="utf-8")
    return tuple(goals)


def _entries(model: FmuModel, platforms: Sequence[Platform]) -> Mapping[str, bytes]:
    """The files of the archive by name."""
    identifier = model.description.identifier
    entries: dict[str, bytes] = {}
    parts = (model.description, model.table, model.structure)
    picture = _picture(model)
    if model.version == 2:
        entries["modelDescription.xml"] = fmi2_description(*parts).encode()
        icon = "model.png"
    else:
        devices = [device.name for device in model.stages.optimised.devices]
        entries["modelDescription.xml"] = fmi3_description(*parts).encode()
        entries["sources/buildDescription.xml"] = build_description(model.description).encode()
        terminals = terminals_and_icons(model.table, devices)
        entries["terminalsAndIcons/terminalsAndIcons.xml"] = terminals.encode()
        icon = "terminalsAndIcons/icon.png"
    entries[f"sources/{identifier}.c"] = model.source.encode()
    folders = binary_folders(platforms, model.version)
    contents = build_binaries(model.source, platforms)
    for each in platforms:
        entries[f"binaries/{folders[each.name]}/{identifier}.{each.ending}"] = contents[each.name]
    if picture is not None:
        entries[icon] = picture
    return entries


def _picture(model: FmuModel) -> bytes | None:
    """The drawing of the bond graph; None without Graphviz."""
    return lay_out(to_dot(model.stages.causal), "png") if shutil.which("dot") else None


def write_archive(path: Path, entries: Mapping[str, bytes]) -> None:
    """Write a zip archive; equal entries make equal archives."""
    with ZipFile(path, "w", ZIP_DEFLATED) as archive:
        for name, content in entries.items():
            info = ZipInfo(name, _EARLIEST)
            info.compress_type = ZIP_DEFLATED
            info.external_attr = 0o644 << 16
            archive.writestr(info, content)
