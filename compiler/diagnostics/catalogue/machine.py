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
    """BG048: the operating system reports an error

    What: the operating system refused a service that every command needs, such as memory, a
    process, or standard output.

    Why: the disk is full, the working directory was deleted, or a limit of the process is reached.

    Example: `bgc run rlc.bg --out - > /dev/full`.

    Way out: remove the reason that the message gives; with `BGC_DEBUG=1` the place in bgc is shown.
    """
    where = f" (`{path}`)" if path else ""
    return error(
        "BG048",
        f"the operating system reports an error: {reason}{where}",
        help="free what it lacks, or run the command elsewhere",
    )


def cache_not_private(path: str, reason: str) -> Diagnostic:
    """BG049: other users may have written to the cache directory

    What: the cache directory belongs to another user, or other users may write to it.

    Why: compiled models in the cache are executed, so somebody who may write to it could run
    programs as you.

    Example: `BGC_CACHE_DIR=/tmp/bgc`, where another user made that directory.

    Way out: delete the directory, which bgc then makes again for you alone, or set `BGC_CACHE_DIR`
    to a directory of your own. Until then every run compiles the model again in a temporary
    directory.
    """
    return warning(
        "BG049",
        f"the cache directory {path} is not used, since {reason}: compiled models are not kept",
        help=f"delete {path} or set `BGC_CACHE_DIR` to a directory of your own",
    )


def no_c_compiler(tried: Sequence[str]) -> Diagnostic:
    """BG050: no C compiler was found

    What: a model is compiled to machine code by a C compiler, and none was found on this machine.

    Why: `$CC`, `cc`, `gcc`, `clang` and the `ziglang` wheel are tried in this order.

    Example: a slim container image with only Python.

    Way out: install gcc or clang with the system's package manager, or `pip install ziglang`.
    """
    names = ", ".join(f"`{name}`" for name in tried)
    return error("BG050", f"no C compiler was found (tried {names})", help=_INSTALL_COMPILER)


def chosen_compiler_missing(command: str) -> Diagnostic:
    """BG051: the compiler named by `$CC` does not exist

    What: the environment variable `CC` names a program that does not exist or cannot be run.

    Why: a compiler chosen by name is never silently replaced by another.

    Example: `CC=gcc-99 bgc run rlc.bg`.

    Way out: correct `CC`, or unset it so that bgc tries `cc`, `gcc` and `clang`.
    """
    return error(
        "BG051",
        f"`$CC` names the C compiler `{command}`, which cannot be run",
        help="correct `CC`, or unset it so that bgc tries `cc`, `gcc` and `clang`",
    )


def compiler_does_not_work(command: str, output: str) -> Diagnostic:
    """BG052: the C compiler does not compile a trivial program

    What: the compiler exists, but fails on ten lines of C that use only the C library.

    Why: usually the headers of the C library are missing, or `CC` is not a C compiler.

    Example: Debian with `gcc` but without `libc6-dev`.

    Way out: install the headers (`apt-get install libc6-dev`), or set `CC` to another compiler.
    """
    return error(
        "BG052",
        f"the C compiler `{command}` does not work: it fails on a trivial program",
        note=output,
        help="install the C library's headers (`apt-get install libc6-dev`), or set `CC` to "
        "another compiler",
    )


def compiler_rejected_code(command: str, output: str, kept: str) -> Diagnostic:
    """BG053: the C compiler failed on the generated code

    What: the compiler works in general, but failed on the C code that bgc generated for this model.

    Why: this is a bug in bgc or in the compiler, or a limit such as the machine's memory.

    Example: gcc runs out of memory on a very large model.

    Way out: report it with the C files and the compiler's output, which are kept.
    """
    return error(
        "BG053",
        f"the C compiler `{command}` failed on the generated code",
        note=output,
        help=f"report it with the C files and the output, which are kept in {kept}",
    )


def cache_not_writable(path: str, reason: str) -> Diagnostic:
    """BG054: the cache directory cannot be written

    What: compiled models are cached in the user's cache directory, and it cannot be written.

    Why: the home directory is read-only, the disk is full, or a file has the directory's name.

    Example: a container that runs as a user without a home directory.

    Way out: set `BGC_CACHE_DIR` to a writable directory. Until then every run compiles the model
    again in a temporary directory.
    """
    return warning(
        "BG054",
        f"the cache directory {path} cannot be written ({reason}): compiled models are not kept",
        help="set `BGC_CACHE_DIR` to a writable directory",
    )


def cannot_write(path: str, reason: str) -> Diagnostic:
    """BG055: a file cannot be written

    What: the operating system does not allow a file to be written.

    Why: the disk is full, a permission is missing, or the directory does not exist.

    Example: `bgc run rlc.bg --out /missing/r.csv`.

    Way out: write elsewhere, create the directory, or free some space. An existing file of that
    name is unchanged.
    """
    return error(
        "BG055",
        f"cannot write {path}: {reason}",
        help="choose another place, create the directory or free some space",
    )


def rows_not_written(path: str, reason: str, time: float, rows: int) -> Diagnostic:
    """BG590: the rows of a run can no longer be written

    What: the rows of a long run go to a file while it goes on, and the operating system refused
    some of them. The run ended there.

    Why: the disk became full, or a network drive is gone.

    Example: `bgc run rlc.bg --time "1 h" --every "1 us" --out /tmp/r.csv`, 3.6 billion rows.

    Way out: the file can be read and has the rows that the message counts. Free some space, write
    to another disk, or write fewer rows: `--every`.
    """
    return error(
        "BG590",
        f"cannot write more rows to {path}: {reason}",
        note=f"the file can be read and has the {rows:,} rows up to t = {time:.9g} s",
        help="free some space, write to another disk, or write fewer rows with `--every`",
    )


def no_temporary_files(folder: str, reason: str) -> Diagnostic:
    """BG642: temporary files cannot be written

    What: a C compiler reads and writes files in a temporary folder, which the operating system does
    not allow.

    Why: the disk of that folder is full, the size of files is limited (`ulimit -f`), or a
    permission is missing.

    Example: `ulimit -f 20; bgc build rlc.bg --target fmu2`.

    Way out: free some space there, raise the limit, or set `TMPDIR` to another folder.
    """
    return error(
        "BG642",
        f"cannot write temporary files in {folder}: {reason}",
        help="free some space there, or set `TMPDIR` to another folder",
    )


def dot_missing() -> Diagnostic:
    """BG056: Graphviz is not installed

    What: bond graphs are laid out by the program `dot` of Graphviz, which was not found.

    Why: Graphviz is not a Python package, so it is not installed with bgc.

    Example: `bgc graph rlc.bg -o rlc.svg` on a new machine.

    Way out: install Graphviz (`apt-get install graphviz`, `brew install graphviz`), or write the
    graph as text: `-o rlc.dot`.
    """
    return error(
        "BG056",
        "the program `dot` of Graphviz was not found",
        help="install it (`apt-get install graphviz`, `brew install graphviz`), or write the graph "
        "as text with `-o FILE.dot`",
    )


def dot_failed(output: str) -> Diagnostic:
    """BG057: Graphviz failed

    What: `dot` was found but ended with an error.

    Why: usually this build of Graphviz lacks the output format.

    Example: `-o rlc.pdf` with a Graphviz built without cairo.

    Way out: write SVG, or the graph as text: `-o FILE.dot`.
    """
    return error(
        "BG057",
        "the program `dot` of Graphviz failed",
        note=output,
        help="write SVG, or the graph as text with `-o FILE.dot`",
    )


def package_missing(package: str, purpose: str, extra: str) -> Diagnostic:
    """BG058: an optional Python package is missing

    What: this function needs a Python package that bgc does not otherwise require.

    Why: packages that few users need are optional.

    Example: `result.to_pandas()` without pandas.

    Way out: install the package or the extra that the help names.
    """
    return error(
        "BG058",
        f"{purpose} needs the Python package `{package}`",
        help=f"run `pip install {package}`, or install bgc with its extra `{extra}`",
    )


def cannot_load(path: str, reason: str) -> Diagnostic:
    """BG059: a compiled model cannot be loaded

    What: the shared object exists, but this Python cannot load it.

    Why: it was built on another machine or by another version of bgc, or is not a compiled model.

    Example: a `.so` copied from an x86 machine to an ARM one.

    Way out: build it again on this machine from the `.bg` file.
    """
    return error(
        "BG059",
        f"cannot load the compiled model {path}: {reason}",
        help="build it again on this machine from the `.bg` file",
    )


def unknown_file_kind(path: str, kinds: Sequence[str]) -> Diagnostic:
    """BG070: an output file with an unknown ending

    What: the ending of an output file's name selects its format, and this ending is not supported.

    Why: the format of an output file is not given separately.

    Example: `--out r.xlsx`.

    Way out: use one of the endings that the help lists.
    """
    listed = ", ".join(f"`{kind}`" for kind in kinds)
    return error(
        "BG070", f"the ending of {path} is not a known output format", help=f"use {listed}"
    )


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
