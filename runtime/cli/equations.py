"""`bgc equations`."""

from __future__ import annotations

from pathlib import Path

import click

from bgc.diagnostics.catalogue.machine import unknown_file_kind
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.ir.program import Program
from bgc.options import Options
from bgc.printing.latex import latex_equations
from bgc.printing.stages import show_equations, symbol_names
from bgc.printing.tables import Table
from bgc.runtime.cli.app import print_diagnostics
from bgc.runtime.cli.options import (
    input_option,
    model_file,
    output_option,
    point_options,
    read_assignments,
    read_pair,
    read_point,
    read_uses,
    scene_option,
    set_option,
    use_option,
)
from bgc.runtime.cli.printing import print_tables, text_width
from bgc.runtime.linear.tables import linear_tables, write_csv, write_npz
from bgc.runtime.linearising.operating import OpenedModel

_LINES = 300  # of equations that are printed without --full
_KINDS = (".csv", ".npz")


@click.command()
@model_file
@scene_option
@set_option
@use_option
@click.option("--latex", is_flag=True, help="Print LaTeX for the package amsmath.")
@click.option(
    "--linear",
    "--state-space",
    "linear",
    is_flag=True,
    help="Print A, B, C, D and modes at an operating point; by default the initial state.",
)
@point_options
@input_option(multiple=True)
@output_option(multiple=True)
@click.option(
    "--transfer",
    "transfers",
    multiple=True,
    metavar="OUTPUT/INPUT",
    help="Print a transfer function in the model's letters, its poles, zeros and static gain.",
)
@click.option("--full", is_flag=True, help="Print everything, however long.")
@click.option("--out", metavar="FILE", help="Write the matrices: .csv or .npz.")
def equations(
    file: Path,
    scene: str | None,
    assignments: tuple[str, ...],
    uses: tuple[str, ...],
    latex: bool,
    linear: bool,
    at: str | None,
    steady: bool,
    inputs: tuple[str, ...],
    outputs: tuple[str, ...],
    transfers: tuple[str, ...],
    full: bool,
    out: str | None,
) -> None:
    """Print the state equations of a scene of FILE, their linear form, or a transfer function.

    Inputs are a source's effort or flow (supply.e), a parameter (mass) or a device's channel;
    by default those of the devices. Outputs are what the scene observes, or any expressions.

    A transfer function is that of the linear form, a formula in the model's parameters; states of
    a nonlinear model stand in it as letters. Numbers beside it are for the initial state, or for
    that of --at or --steady.
    """
    if linear and (latex or transfers):
        raise click.UsageError("--linear excludes --latex and --transfer; it has --out FILE")
    if not linear and (inputs or outputs or out is not None):
        raise click.UsageError("--input, --output and --out need --linear")
    if not linear and not transfers and (at is not None or steady):
        raise click.UsageError("--at and --steady need --linear or --transfer")
    options = Options(scene, read_assignments(assignments), uses=read_uses(uses))
    if transfers:
        _print_transfers(file, options, at, steady, transfers, latex=latex, full=full)
        return
    if linear:
        _print_linear(file, options, at, steady, inputs, outputs, full, out)
        return
    stages = compile_scene(file, options, until="optimise")
    print_diagnostics(stages.warnings)
    if latex:
        program = stages.optimised
        click.echo(latex_equations(program, symbol_names(program)), nl=False)
    else:
        _print_equations(stages.optimised, full)


def _print_equations(program: Program, full: bool) -> None:
    """Print the equations as text, or a summary of very long ones."""
    text = show_equations(program) or "no states, and nothing is observed\n"
    length = text.count("\n")
    if full or length <= _LINES:
        click.echo(text, nl=False)
        return
    states = tuple((s.name, s.unit, s.kind) for s in program.states)
    observed = tuple((o.name, o.unit) for o in program.observations)
    print_tables(
        (
            Table("states", ("name", "unit", "kind"), states),
            Table("observed", ("name", "unit"), observed),
            Table("equations", (), (), f"{length} lines; --full prints them"),
        )
    )


def _print_transfers(
    file: Path,
    options: Options,
    at: str | None,
    steady: bool,
    transfers: tuple[str, ...],
    *,
    latex: bool,
    full: bool,
) -> None:
    """Transfer functions one below the other, as text or LaTeX."""
    # These import SymPy, which takes 0.3 s and which only transfer functions need.
    from bgc.runtime.linearising.symbolic import transfer_at
    from bgc.symbolic.latex import transfer_latex
    from bgc.symbolic.terminal import transfer_lines, transfer_tables

    pairs = [read_pair(text) for text in transfers]
    point = read_point(at, steady)
    for k, (output, input_) in enumerate(pairs):
        function, values, warnings = transfer_at(file, options, output, input_, point)
        if k == 0:
            print_diagnostics(warnings)
        else:
            click.echo()
        if latex:
            click.echo(transfer_latex(function, values, full), nl=False)
            continue
        click.echo("\n".join(transfer_lines(function, text_width(), full)) + "\n")
        print_tables(transfer_tables(function, values, full))


def _print_linear(
    file: Path,
    options: Options,
    at: str | None,
    steady: bool,
    inputs: tuple[str, ...],
    outputs: tuple[str, ...],
    full: bool,
    out: str | None,
) -> None:
    if out is not None and Path(out).suffix.lower() not in _KINDS:
        raise BgError([unknown_file_kind(out, _KINDS)])
    point = read_point(at, steady)
    opened = OpenedModel(file, options, inputs, outputs)
    linear = opened.linearise(opened.operating_point(point))
    print_diagnostics(linear.warnings)
    print_tables(linear_tables(linear, full))
    if not linear.states and not linear.inputs:
        click.echo("no states: give an `--input`, to see what an output owes to it")
    if out is not None:
        (write_npz if Path(out).suffix.lower() == ".npz" else write_csv)(linear, Path(out))
