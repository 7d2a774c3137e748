"""Understand 2: print the state equations, or their linear form and modes."""

from pathlib import Path

from bgc.diagnostics.catalogue.symbolic import bad_pair
from bgc.ir.program import Program
from bgc.printing.latex import latex_equations
from bgc.printing.stages import show_equations, symbol_names
from bgc.printing.text_tables import Table
from bgc.runtime.cli.command import Pair, Target, command, option, require
from bgc.runtime.cli.linear_options import LinearOptions
from bgc.runtime.cli.options import Inputs, Outputs, PointOptions, SceneOptions
from bgc.runtime.cli.printing import (
    print_diagnostics,
    print_tables,
    print_text,
    text_width,
)
from bgc.runtime.linear.linear_tables import linear_tables, write_csv, write_npz

_LINES = 300  # of equations that are printed without --full


@command()
def equations(
    scene: SceneOptions,
    *,
    latex: bool = option("Print LaTeX for the package amsmath."),
    linear: bool = option(
        "Print A, B, C, D and modes at an operating point; by default the initial state.",
        "--linear",
        "--state-space",
    ),
    point: PointOptions,
    inputs: Inputs,
    outputs: Outputs,
    transfers: tuple[tuple[str, str], ...] = option(
        "Print a transfer function in the model's letters, its poles, zeros and static gain.",
        "--transfer",
        type=Pair(bad_pair, "/"),
        metavar="OUTPUT/INPUT",
    ),
    full: bool = option("Print everything, however long."),
    out: str | None = option("Write the matrices: .csv or .npz.", type=Target(".csv", ".npz")),
) -> None:
    """Print the state equations of a scene of FILE, their linear form, or a transfer function.

    Inputs are a source's effort or flow (supply.e), a parameter (mass) or a device's channel;
    by default those of the devices. Outputs are what the scene observes, or any expressions.

    A transfer function is that of the linear form, a formula in the model's parameters; states of
    a nonlinear model stand in it as letters. Numbers beside it are for the initial state, or for
    that of --at or --steady.
    """
    require(
        not (linear and (latex or transfers)),
        "--linear excludes --latex and --transfer; it has --out FILE",
    )
    require(linear or not (inputs or outputs or out), "--input, --output and --out need --linear")
    require(
        linear or transfers or not point.is_given, "--at and --steady need --linear or --transfer"
    )
    if transfers:
        _print_transfers(scene, point, transfers, latex, full)
    elif linear:
        _print_linear(LinearOptions(scene, point), inputs, outputs, full, out)
    else:
        program = scene.stages("optimise").optimised
        if latex:
            print_text(latex_equations(program, symbol_names(program)))
        else:
            _print_equations(program, full)


def _print_equations(program: Program, full: bool) -> None:
    """Print the equations as text, or a summary of very long ones."""
    text = show_equations(program) or "no states, and nothing is observed\n"
    length = text.count("\n")
    if full or length <= _LINES:
        print_text(text)
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
    scene: SceneOptions,
    point: PointOptions,
    transfers: tuple[tuple[str, str], ...],
    latex: bool,
    full: bool,
) -> None:
    """Transfer functions one below the other, as text or LaTeX."""
    # These import SymPy, which takes 0.3 s and which only transfer functions need.
    from bgc.runtime.linearising.symbolic import transfer_at
    from bgc.symbolic.transfer_latex import transfer_latex
    from bgc.symbolic.transfer_text import transfer_lines, transfer_tables

    for k, (output, input_) in enumerate(transfers):
        found = transfer_at(scene.file, scene.options(), output, input_, point.point)
        function, values, warnings = found
        if k == 0:
            print_diagnostics(warnings)
        else:
            print_text("\n")
        if latex:
            print_text(transfer_latex(function, values, full))
        else:
            print_text("\n".join(transfer_lines(function, text_width(), full)) + "\n\n")
            print_tables(transfer_tables(function, values, full))


def _print_linear(
    model: LinearOptions,
    inputs: tuple[str, ...],
    outputs: tuple[str, ...],
    full: bool,
    out: str | None,
) -> None:
    linear = model.linear(inputs, outputs)
    print_tables(linear_tables(linear, full))
    if not linear.states and not linear.inputs:
        print_text("no states: give an `--input`, to see what an output owes to it")
    if out is not None:
        (write_npz if Path(out).suffix.lower() == ".npz" else write_csv)(linear, Path(out))
