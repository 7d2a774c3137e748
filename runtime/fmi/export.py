"""Make an FMU: a zip archive of description, binaries, sources and pictures."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from io import BytesIO
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from bgc.building.cache import open_cache
from bgc.building.platforms import Platform
from bgc.printing.draw import lay_out, to_dot
from bgc.runtime.fmi.binaries import binary_folders, build_binaries
from bgc.runtime.fmi.companions import osp_description, reference_files
from bgc.runtime.fmi.fmu_model import FmuModel
from bgc.runtime.fmi.model_description import (
    build_description,
    fmi2_description,
    fmi3_description,
    terminals_and_icons,
)

_EARLIEST = (1980, 1, 1, 0, 0, 0)  # of a zip archive: equal models make equal archives


def fmu_files(
    model: FmuModel, platforms: Sequence[Platform], reference: bool = False
) -> Mapping[str, bytes]:
    """Make an FMU and the files beside it: the content of each by name, the FMU first.

    An FMU of FMI 2 has its groups of variables for OSP beside it; with `reference` there are the
    files of a cross-check too.

    Raises BgError: BG751 and BG752 where a platform does not build.
    """
    texts = {"_OspModelDescription.xml": osp_description(model)} if model.version == 2 else {}
    texts |= reference_files(model) if reference else {}
    name = model.description.identifier
    files = {f"{name}.fmu": fmu_archive(model, platforms)}
    return files | {f"{name}{ending}": text.encode() for ending, text in texts.items()}


def fmu_archive(model: FmuModel, platforms: Sequence[Platform]) -> bytes:
    """Make the FMU itself; raises BgError BG751 and BG752 where a platform does not build."""
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
    entries[f"sources/{identifier}.c"] = model.source.text.encode()
    folders = binary_folders(platforms, model.version)
    contents = build_binaries(model.source, platforms, open_cache())
    for each in platforms:
        entries[f"binaries/{folders[each.name]}/{identifier}.{each.ending}"] = contents[each.name]
    if picture is not None:
        entries[icon] = picture
    return archived(entries)


def _picture(model: FmuModel) -> bytes | None:
    """The drawing of the bond graph; None without Graphviz."""
    return lay_out(to_dot(model.stages.causal), "png") if shutil.which("dot") else None


def archived(entries: Mapping[str, bytes]) -> bytes:
    """Pack a zip archive; equal entries make equal archives."""
    packed = BytesIO()
    with ZipFile(packed, "w", ZIP_DEFLATED) as archive:
        for name, content in entries.items():
            info = ZipInfo(name, _EARLIEST)
            info.compress_type = ZIP_DEFLATED
            info.external_attr = 0o644 << 16
            archive.writestr(info, content)
    return packed.getvalue()
