"""The files of FMUs of other tools: unpacked into the cache, and opened from there.

An FMU holds a program, which a run executes. It is unpacked when its user imports it, or where the
user has listed its folder; a scene alone does not cause that.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path
from zipfile import BadZipFile, ZipFile

from bgc.building.cache import Cache, open_cache
from bgc.building.platforms import PLATFORMS, host_platform
from bgc.diagnostics.catalogue.fmu_parts import (
    fmu_not_imported,
    fmu_not_opened,
    fmu_without_binary,
)
from bgc.diagnostics.diagnostic import BgError
from bgc.ir.port_facts import FmuFacts
from bgc.runtime.running.allowed_folders import ALLOWED, is_allowed
from bgc.values.fmu_files import FmuFault, read_fmu

_MOST_BYTES = 2_000_000_000  # of an unpacked FMU


class FmuFolder:
    """The unpacked files of an FMU for one instance: its binary, and where its resources are."""

    def __init__(self, fmu: FmuFacts) -> None:
        folder = _unpacked(fmu)
        binaries = folder / "binaries"
        endings = {each.ending for each in PLATFORMS.values() if each.name == host_platform()}
        wanted = _platform_folders(fmu.version)
        found = [
            path
            for name in wanted
            for ending in endings
            if (path := binaries / name / f"{fmu.identifier}.{ending}").is_file()
        ]
        if not found:
            others = sorted(path.name for path in binaries.glob("*"))
            kind = wanted[0] if wanted else "of no kind that FMUs know"
            raise BgError([fmu_without_binary(fmu.file, kind, others)])
        self.library = found[0]
        self._copy = tempfile.TemporaryDirectory(prefix="bgc-") if fmu.once else None
        if self._copy is not None:  # a library of its own: its instance is alone there
            shutil.copytree(self.library.parent, self._copy.name, dirs_exist_ok=True)
            self.library = Path(self._copy.name) / self.library.name
        resources = folder / "resources"
        self.resources = resources.as_uri() if fmu.version == 2 else f"{resources}/"

    def close(self) -> None:
        """Remove the library of its own, where it has one."""
        if self._copy is not None:
            self._copy.cleanup()


def allow_fmu(path: Path, digest: str) -> None:
    """Unpack an FMU into the cache, so that runs on this machine may execute it."""
    _unpack(path, digest, open_cache())


def _platform_folders(version: int) -> tuple[str, ...]:
    """The folders of binaries for this machine, the one of the standard first."""
    host = PLATFORMS.get(host_platform())
    if host is None:
        return ()
    own = (host.folder3, host.folder2)
    return own if version == 3 or "aarch64" in host.name else own[::-1]


def _place(digest: str, cache: Cache) -> Path:
    return cache.root / "fmus" / digest[:32]


def _unpacked(fmu: FmuFacts) -> Path:
    """The folder of an FMU; BG670 where nobody has imported it here."""
    cache = open_cache()
    place = _place(fmu.digest, cache)
    if not place.is_dir():
        if not is_allowed(Path(fmu.path)):
            raise BgError([fmu_not_imported(fmu.file, ALLOWED)])
        try:
            digest = read_fmu(Path(fmu.path), fmu.file).digest
        except FmuFault as reason:
            raise BgError([fmu_not_opened(fmu.file, str(reason))]) from reason
        if digest != fmu.digest:
            raise BgError([fmu_not_opened(fmu.file, "it has changed since the model was compiled")])
        _unpack(Path(fmu.path), fmu.digest, cache)
    os.utime(place)  # the last use, for `prune`
    return place


def _unpack(path: Path, digest: str, cache: Cache) -> None:
    """Unpack the binaries and resources of an FMU; BG672 where that is not possible."""
    place = _place(digest, cache)
    if place.is_dir():
        return
    try:
        with cache.workplace() as work, ZipFile(path) as archive:
            files = [info for info in archive.infolist() if not info.is_dir()]
            wanted = [f for f in files if f.filename.startswith(("binaries/", "resources/"))]
            if sum(info.file_size for info in wanted) > _MOST_BYTES:
                reason = f"it unpacks to more than {_MOST_BYTES:,} bytes"
                raise BgError([fmu_not_opened(str(path), reason)])
            for info in wanted:
                archive.extract(info, work)  # which keeps within the folder
            (Path(work) / "resources").mkdir(exist_ok=True)
            place.parent.mkdir(parents=True, exist_ok=True)
            made = Path(work) / "made"
            made.mkdir()
            for part in ("binaries", "resources"):
                if (Path(work) / part).is_dir():
                    (Path(work) / part).rename(made / part)
            made.replace(place)
    except (BadZipFile, OSError, RuntimeError, NotImplementedError) as problem:
        if not place.is_dir():  # else another process was quicker
            reason = getattr(problem, "strerror", None) or str(problem)
            raise BgError([fmu_not_opened(str(path), reason)]) from problem
