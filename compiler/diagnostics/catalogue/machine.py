"""Diagnostics of the machine a model meets: C compiler, cache, files written, packages."""

from __future__ import annotations

from collections.abc import Sequence

from bgc.diagnostics.catalogue import error, warning
from bgc.diagnostics.diagnostic import Diagnostic

_INSTALL_COMPILER = (
    "install one (`apt-get install gcc`, `xcode-select --install`) or the compiler that comes "
    "as a Python package (`pip install ziglang`); `bgc doctor` shows what is found"
)


def no_c_compiler(tried: Sequence[str]) -> Diagnostic:
    """BG050: no C compiler was found

    What: a model becomes machine code through a C compiler, and none is on this machine.

    Why: `$CC`, `cc`, `gcc`, `clang` and the `ziglang` wheel are looked for, in this order.

    Example: a slim container image with Python alone.

    Way out: install gcc or clang with the system's package manager, or `pip install ziglang`.
    """
    names = ", ".join(f"`{name}`" for name in tried)
    return error("BG050", f"no C compiler was found (tried {names})", help=_INSTALL_COMPILER)


def chosen_compiler_missing(command: str) -> Diagnostic:
    """BG051: the compiler named by `$CC` is not there

    What: the environment variable `CC` names a program that does not exist or cannot be run.

    Why: a compiler that was asked for by name is never silently replaced by another.

    Example: `CC=gcc-99 bgc run rlc.bg`.

    Way out: correct `CC`, or unset it to let bgc look for `cc`, `gcc` and `clang`.
    """
    return error(
        "BG051",
        f"`$CC` names the C compiler `{command}`, which cannot be run",
        help="correct `CC`, or unset it to let bgc look for `cc`, `gcc` and `clang`",
    )


def compiler_does_not_work(command: str, output: str) -> Diagnostic:
    """BG052: the C compiler does not compile a trivial program

    What: the compiler was found, but fails on ten lines of C that use only the C library.

    Why: mostly the headers of the C library are missing, or `CC` is not a C compiler.

    Example: Debian with `gcc` but without `libc6-dev`.

    Way out: `apt-get install libc6-dev`, or another compiler through `CC`.
    """
    return error(
        "BG052",
        f"the C compiler `{command}` does not work: it fails on a trivial program",
        note=output,
        help="install the C library's headers (`apt-get install libc6-dev`), or name another "
        "compiler in `CC`",
    )


def compiler_rejected_code(command: str, output: str, kept: str) -> Diagnostic:
    """BG053: the C compiler failed on the emitted code

    What: the compiler works, but not on the C that bgc emitted for this model.

    Why: a defect of bgc, of the compiler, or a limit such as the machine's memory.

    Example: gcc killed for lack of memory on a very large model.

    Way out: the C files and the compiler's words are kept: please report them.
    """
    return error(
        "BG053",
        f"the C compiler `{command}` failed on the emitted code",
        note=output,
        help=f"the C files and the whole output are kept in {kept}: please report them",
    )


def cache_not_writable(path: str, reason: str) -> Diagnostic:
    """BG054: the cache directory cannot be written

    What: compiled models are kept in the user's cache directory, which cannot be written.

    Why: a read-only home, no space left, or a file where the directory should be.

    Example: a container that runs as a user without a home.

    Way out: set `BGC_CACHE_DIR` to a directory that can be written. Until then everything is
    compiled anew in a temporary directory.
    """
    return warning(
        "BG054",
        f"the cache directory {path} cannot be written ({reason}): nothing is kept for next time",
        help="set `BGC_CACHE_DIR` to a directory that can be written",
    )


def cannot_write(path: str, reason: str) -> Diagnostic:
    """BG055: a file cannot be written

    What: the operating system refused to write a file.

    Why: no space left, no permission, or the directory does not exist.

    Example: `bgc run rlc.bg --out /missing/r.csv`.

    Way out: write elsewhere, make the directory, or free some space. A file of that name from
    an earlier run is untouched.
    """
    return error(
        "BG055",
        f"cannot write {path}: {reason}",
        help="choose another place, make the directory or free some space",
    )


def dot_missing() -> Diagnostic:
    """BG056: Graphviz is not installed

    What: a bond graph is laid out by the program `dot` of Graphviz, which was not found.

    Why: Graphviz is no Python package: it cannot come with bgc.

    Example: `bgc graph rlc.bg -o rlc.svg` on a bare machine.

    Way out: `apt-get install graphviz` (`brew install graphviz`), or `-o rlc.dot` for the text.
    """
    return error(
        "BG056",
        "the program `dot` of Graphviz was not found",
        help="`apt-get install graphviz` (`brew install graphviz`), or write the graph's text "
        "with `-o FILE.dot`",
    )


def dot_failed(output: str) -> Diagnostic:
    """BG057: Graphviz failed

    What: `dot` was found but ended with an error.

    Why: mostly a build of Graphviz without the wanted output format.

    Example: `-o rlc.pdf` with a Graphviz built without cairo.

    Way out: write SVG, or the graph's text with `-o FILE.dot`.
    """
    return error(
        "BG057",
        "the program `dot` of Graphviz failed",
        note=output,
        help="write SVG, or the graph's text with `-o FILE.dot`",
    )


def package_missing(package: str, purpose: str, extra: str) -> Diagnostic:
    """BG058: an optional Python package is missing

    What: this function needs a Python package that bgc does not require otherwise.

    Why: packages that few users need are extras.

    Example: `result.to_pandas()` without pandas.

    Way out: install the extra that is named.
    """
    return error(
        "BG058",
        f"{purpose} needs the Python package `{package}`",
        help=f"`pip install {package}`, or the extra `{extra}` of bgc",
    )


def cannot_load(path: str, reason: str) -> Diagnostic:
    """BG059: a compiled model cannot be loaded

    What: the shared object exists but this Python cannot load it.

    Why: built on another machine, by another version of bgc, or not a compiled model at all.

    Example: a `.so` copied from an x86 machine to an ARM one.

    Way out: build it again here from the `.bg` file.
    """
    return error(
        "BG059",
        f"cannot load the compiled model {path}: {reason}",
        help="build it again on this machine from the `.bg` file",
    )


def unknown_file_kind(path: str, kinds: Sequence[str]) -> Diagnostic:
    """BG070: a file name whose ending tells no known kind

    What: the ending of an output file's name says in which form it is written.

    Why: the one given is not among those that can be written.

    Example: `--out r.xlsx`.

    Way out: one of the endings named.
    """
    listed = ", ".join(f"`{kind}`" for kind in kinds)
    return error("BG070", f"cannot tell from its name how to write {path}", help=f"use {listed}")


def nothing_to_draw(reason: str) -> Diagnostic:
    """BG075: there is nothing to plot

    What: a plot needs at least one observed column and two rows.

    Why: the scene observes nothing, or the run ended at its start.

    Example: `bgc run f.bg --plot p.png` where the scene has no `observe`.

    Way out: add `observe NAME;` to the scene.
    """
    return error(
        "BG075", f"there is nothing to plot: {reason}", help="add `observe NAME;` to the scene"
    )
