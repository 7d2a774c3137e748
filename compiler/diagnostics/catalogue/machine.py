"""Diagnostics: C compiler, cache, output files and packages."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import Values, error, warning

_INSTALL_COMPILER = (
    "install one (`apt-get install gcc`, `xcode-select --install`) or the compiler that comes "
    "as a Python package (`pip install ziglang`); `bgc doctor` shows what is found"
)


@error(
    "BG048: the operating system reports an error: {reason}{where}",
    "free what it lacks, or run the command elsewhere",
)
def system_refuses(reason: str, path: str) -> Values:
    return {"where": f" (`{path}`)" if path else ""}


@warning(
    "BG049: the cache directory {path} is not used, since {reason}: compiled models are not kept",
    "delete {path} or set `BGC_CACHE_DIR` to a directory of your own",
)
def cache_not_private(path: str, reason: str) -> None: ...
@error("BG050: no C compiler was found (tried {tried:quoted})", _INSTALL_COMPILER)
def no_c_compiler(tried: Sequence[str]) -> None: ...
@error(
    "BG051: `$CC` names the C compiler `{command}`, which cannot be run",
    "correct `CC`, or unset it so that bgc tries `cc`, `gcc` and `clang`",
)
def chosen_compiler_missing(command: str) -> None: ...
@error(
    "BG052: the C compiler `{command}` does not work: it fails on a trivial program",
    "install the C library's headers (`apt-get install libc6-dev`), or set `CC` to "
    "another compiler",
    note="{output}",
)
def compiler_does_not_work(command: str, output: str) -> None: ...
@error(
    "BG053: the C compiler `{command}` failed on the generated code",
    "report it with the C files and the output, which are kept in {kept}",
    note="{output}",
)
def compiler_rejected_code(command: str, output: str, kept: str) -> None: ...
@warning(
    "BG054: the cache directory {path} cannot be written ({reason}): compiled models are not kept",
    "set `BGC_CACHE_DIR` to a writable directory",
)
def cache_not_writable(path: str, reason: str) -> None: ...
@error(
    "BG055: cannot write {path}: {reason}",
    "choose another place, create the directory or free some space",
)
def cannot_write(path: str, reason: str) -> None: ...
@error(
    "BG590: cannot write more rows to {path}: {reason}",
    "free some space, write to another disk, or write fewer rows with `--every`",
    note="the file can be read and has the {rows:,} rows up to t = {time:.9g} s",
)
def rows_not_written(path: str, reason: str, time: float, rows: int) -> None: ...
@error(
    "BG642: cannot write temporary files in {folder}: {reason}",
    "free some space there, or set `TMPDIR` to another folder",
)
def no_temporary_files(folder: str, reason: str) -> None: ...
@error(
    "BG056: the program `dot` of Graphviz was not found",
    "install it (`apt-get install graphviz`, `brew install graphviz`), or write the "
    "graph as text with `-o FILE.dot`",
)
def dot_missing() -> None: ...
@error(
    "BG057: the program `dot` of Graphviz failed",
    "write SVG, or the graph as text with `-o FILE.dot`",
    note="{output}",
)
def dot_failed(output: str) -> None: ...
@error(
    "BG058: {purpose} needs the Python package `{package}`",
    "run `pip install {package}`, or install bgc with its extra `{extra}`",
)
def package_missing(package: str, purpose: str, extra: str) -> None: ...
@error(
    "BG059: cannot load the compiled model {path}: {reason}",
    "build it again on this machine from the `.bg` file",
)
def cannot_load(path: str, reason: str) -> None: ...
@error("BG070: the ending of {path} is not a known output format", "use {kinds:quoted}")
def unknown_file_kind(path: str, kinds: Sequence[str]) -> None: ...
@error("BG075: there is nothing to plot: {reason}", "add `observe NAME;` to the scene")
def nothing_to_draw(reason: str) -> None: ...
