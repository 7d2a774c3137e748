"""Platforms for which FMUs have binaries."""

from __future__ import annotations

import platform
import sys

from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class Platform:
    """A platform: its name, folders in FMI 2 and 3, zig's target, and the ending of files."""

    name: str
    folder2: str
    folder3: str
    target: str
    ending: str


PLATFORMS = {
    p.name: p
    for p in (
        Platform("linux64", "linux64", "x86_64-linux", "x86_64-linux-gnu.2.17", "so"),
        Platform("linux-aarch64", "linux64", "aarch64-linux", "aarch64-linux-gnu.2.17", "so"),
        Platform("win64", "win64", "x86_64-windows", "x86_64-windows-gnu", "dll"),
        Platform("darwin64", "darwin64", "x86_64-darwin", "x86_64-macos", "dylib"),
        Platform("darwin-aarch64", "darwin64", "aarch64-darwin", "aarch64-macos", "dylib"),
    )
}
_SYSTEMS = {"linux": "linux", "darwin": "darwin", "win32": "win"}


def host_platform() -> str:
    """The name of this machine's platform; empty where it is none of `PLATFORMS`."""
    system = _SYSTEMS.get(sys.platform, "")
    arm = platform.machine().lower() in ("arm64", "aarch64")
    name = f"{system}-aarch64" if arm else f"{system}64"
    return name if name in PLATFORMS and sys.maxsize > 2**32 else ""
