"""Diagnostics of the machine: C compiler, cache, output files, packages."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, warning
from bgc.diagnostics.diagnostic import Diagnostic

_INSTALL_COMPILER = (
    "install one (`apt-get install gcc`, `xcode-select --install`) or the compiler that comes "
    "as a Python package (`pip install ziglang`); `bgc doctor` shows what is found"
)


def system_refuses(reason: str, path: str) -> Diagnostic:
    """BG048: the operating system reports an error"""
    where = f" (`{path}`)" if path else ""
    return error(
        "BG048",
        f"the operating system reports an error: {reason}{where}",
        help="free what it lacks, or run the command elsewhere",
    )


def cache_not_private(path: str, reason: str) -> Diagnostic:
    """BG049: other users may have written to the cache directory"""
    return warning(
        "BG049",
        f"the cache directory {path} is not used, since {reason}: compiled models are not kept",
        help=f"delete {path} or set `BGC_CACHE_DIR` to a directory of your own",
    )


def no_c_compiler(tried: Sequence[str]) -> Diagnostic:
    """BG050: no C compiler was found"""
    names = ", ".join(f"`{name}`" for name in tried)
    return error("BG050", f"no C compiler was found (tried {names})", help=_INSTALL_COMPILER)


def chosen_compiler_missing(command: str) -> Diagnostic:
    """BG051: the compiler named by `$CC` does not exist"""
    return error(
        "BG051",
        f"`$CC` names the C compiler `{command}`, which cannot be run",
        help="correct `CC`, or unset it so that bgc tries `cc`, `gcc` and `clang`",
    )


def compiler_does_not_work(command: str, output: str) -> Diagnostic:
    """BG052: the C compiler does not compile a trivial program"""
    return error(
        "BG052",
        f"the C compiler `{command}` does not work: it fails on a trivial program",
        note=output,
        help="install the C library's headers (`apt-get install libc6-dev`), or set `CC` to "
        "another compiler",
    )


def compiler_rejected_code(command: str, output: str, kept: str) -> Diagnostic:
    """BG053: the C compiler failed on the generated code"""
    return error(
        "BG053",
        f"the C compiler `{command}` failed on the generated code",
        note=output,
        help=f"report it with the C files and the output, which are kept in {kept}",
    )


def cache_not_writable(path: str, reason: str) -> Diagnostic:
    """BG054: the cache directory cannot be written"""
    return warning(
        "BG054",
        f"the cache directory {path} cannot be written ({reason}): compiled models are not kept",
        help="set `BGC_CACHE_DIR` to a writable directory",
    )


def cannot_write(path: str, reason: str) -> Diagnostic:
    """BG055: a file cannot be written"""
    return error(
        "BG055",
        f"cannot write {path}: {reason}",
        help="choose another place, create the directory or free some space",
    )


def rows_not_written(path: str, reason: str, time: float, rows: int) -> Diagnostic:
    """BG590: the rows of a run can no longer be written"""
    return error(
        "BG590",
        f"cannot write more rows to {path}: {reason}",
        note=f"the file can be read and has the {rows:,} rows up to t = {time:.9g} s",
        help="free some space, write to another disk, or write fewer rows with `--every`",
    )


def no_temporary_files(folder: str, reason: str) -> Diagnostic:
    """BG642: temporary files cannot be written"""
    return error(
        "BG642",
        f"cannot write temporary files in {folder}: {reason}",
        help="free some space there, or set `TMPDIR` to another folder",
    )


def dot_missing() -> Diagnostic:
    """BG056: Graphviz is not installed"""
    return error(
        "BG056",
        "the program `dot` of Graphviz was not found",
        help="install it (`apt-get install graphviz`, `brew install graphviz`), or write the graph "
        "as text with `-o FILE.dot`",
    )


def dot_failed(output: str) -> Diagnostic:
    """BG057: Graphviz failed"""
    return error(
        "BG057",
        "the program `dot` of Graphviz failed",
        note=output,
        help="write SVG, or the graph as text with `-o FILE.dot`",
    )


def package_missing(package: str, purpose: str, extra: str) -> Diagnostic:
    """BG058: an optional Python package is missing"""
    return error(
        "BG058",
        f"{purpose} needs the Python package `{package}`",
        help=f"run `pip install {package}`, or install bgc with its extra `{extra}`",
    )


def cannot_load(path: str, reason: str) -> Diagnostic:
    """BG059: a compiled model cannot be loaded"""
    return error(
        "BG059",
        f"cannot load the compiled model {path}: {reason}",
        help="build it again on this machine from the `.bg` file",
    )


def unknown_file_kind(path: str, kinds: Sequence[str]) -> Diagnostic:
    """BG070: an output file with an unknown ending"""
    listed = ", ".join(f"`{kind}`" for kind in kinds)
    return error(
        "BG070", f"the ending of {path} is not a known output format", help=f"use {listed}"
    )


def nothing_to_draw(reason: str) -> Diagnostic:
    """BG075: there is nothing to plot"""
    return error(
        "BG075", f"there is nothing to plot: {reason}", help="add `observe NAME;` to the scene"
    )
