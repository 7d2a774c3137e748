"""A scene's equations as SymPy expressions in the model's own letters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path

import sympy

from bgc.diagnostics.catalogue import analysis
from bgc.diagnostics.catalogue import symbolic as catalogue
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.linearising.analysis_scene import Opened, open_scene
from bgc.options import Options
from bgc.symbolic.determinants import Budget
from bgc.symbolic.pencil import SingularPencil, transfer_ratio
from bgc.symbolic.roots import factored
from bgc.symbolic.symbolic_equilibria import NoFormula, solve_equilibrium
from bgc.symbolic.system import SymbolicSystem, Value, exact
from bgc.symbolic.transfer import TransferFunction
from bgc.values.units import quotient_unit

MOST_PRODUCTS = 10_000_000  # of terms, for one transfer function
MOST_TERMS = 50_000  # of the polynomials that are kept at a time
_NO_SUCH_RATE = "BG522"


class SymbolicModel:
    """The equations `M x' = f(x, u, p, t)`, `y = g(x, u, p, t)` of a scene, in its own letters.

    Made by `bgc.Model.symbolic`. Letters are plain SymPy symbols (without assumptions) with the
    names that `bgc equations` prints: parameters (`R`, `motor.R`), states (`coil.p`), inputs
    (`supply.e`), `time`. All values are SI. Each result is computed when it is first asked for.

    The letter of an input is the whole effort or flow of a source whose value depends on
    parameters and the time alone; for other sources it is added to the scene's value.
    Signs are the model's: power is positive along the half arrow.

    Examples
    --------
    >>> sym = bgc.compile("rlc.bg").symbolic()  # doctest: +SKIP
    >>> sym.f  # doctest: +SKIP
    Matrix([[-R*coil.p/L + supply.e - capacitor.q/C], [coil.p/L]])
    >>> sym.transfer("capacitor.e", "supply.e")  # doctest: +SKIP
    1/(C*L*s**2 + C*R*s + 1)
    """

    def __init__(
        self,
        path: Path,
        options: Options,
        inputs: Sequence[str] = (),
        outputs: Sequence[str] = (),
        values: Mapping[str, float] | None = None,
        point: Mapping[str, sympy.Expr] | None = None,
    ) -> None:
        """Take a scene, other numbers for parameters, and values of letters as operating point."""
        self._path, self._options = path, options
        self._inputs, self._outputs = tuple(inputs), tuple(outputs)
        self._given = dict(values or {})
        self._point = dict(point or {})
        self._functions: dict[tuple[str, str], TransferFunction] = {}

    @cached_property
    def _system(self) -> SymbolicSystem:
        try:
            opened = self._open(self._inputs, self._outputs, total=True)
        except BgError as problem:
            codes = {diagnostic.code for diagnostic in problem.diagnostics}
            if self._inputs or _NO_SUCH_RATE not in codes:
                raise
            # the equations need the rate of a source: leave sources as the scene sets them
            opened = self._open((), self._outputs, total=False)
        return SymbolicSystem(opened, self._point)

    def _open(self, inputs: Sequence[str], outputs: Sequence[str], *, total: bool) -> Opened:
        return open_scene(self._path, self._options, inputs, outputs, self._given, total=total)

    def __repr__(self) -> str:
        return f"<bgc symbolic model of {self._path.name}: f, g, A, B, C, D, transfer(..)>"

    # --- letters ------------------------------------------------------------------------------

    @property
    def parameters(self) -> tuple[sympy.Symbol, ...]:
        """Letters of the parameters, in the order of the file."""
        return self._system.letters.parameters

    @property
    def states(self) -> tuple[sympy.Symbol, ...]:
        """Letters of the states x, (n,)."""
        return self._system.letters.states

    @property
    def inputs(self) -> tuple[sympy.Symbol, ...]:
        """Letters of the inputs u, (m,)."""
        return self._system.letters.inputs

    @property
    def outputs(self) -> tuple[sympy.Symbol, ...]:
        """Names of the outputs y as symbols, (p,)."""
        return tuple(sympy.Symbol(o.name) for o in self._system.program.observations)

    @property
    def time(self) -> sympy.Symbol:
        """The time `time`, s."""
        return self._system.letters.time

    @property
    def laplace(self) -> sympy.Symbol:
        """The Laplace variable `s`, 1/s; `s_` where the model has an `s` of its own."""
        return self._system.letters.laplace

    @cached_property
    def values(self) -> dict[sympy.Symbol, float]:
        """The scene's number for each letter, SI; states and inputs are as at the start."""
        return self._system.numbers()

    @property
    def dependent(self) -> dict[sympy.Symbol, sympy.Expr]:
        """Parameters whose values follow from others, `{motor.R: Ra}`.

        Each is a letter of its own, since it can be set separately; `G.subs(sym.dependent)`
        replaces it by its default.
        """
        return self._system.dependent

    @cached_property
    def start(self) -> dict[sympy.Symbol, sympy.Expr]:
        """Initial values of the states; algebraic ones, which follow from others, have none."""
        return self._system.start()

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """Warnings of the compiler about the scene."""
        return self._system.opened.warnings

    # --- equations ----------------------------------------------------------------------------

    @cached_property
    def f(self) -> sympy.Matrix:
        """The right-hand sides of `M x' = f`, (n, 1), at any state."""
        program = self._system.program
        return sympy.Matrix(self._system.general([s.derivative for s in program.states]))

    @cached_property
    def g(self) -> sympy.Matrix:
        """The outputs y, (p, 1), at any state."""
        program = self._system.program
        return sympy.Matrix(self._system.general([o.node for o in program.observations]))

    @cached_property
    def M(self) -> sympy.Matrix:
        """The mass matrix, (n, n): the identity unless equations hold rates implicitly."""
        return self._system.mass()

    @cached_property
    def A(self) -> sympy.Matrix:
        """The derivatives of f by x, (n, n), at the operating point."""
        return self._system.block("A", (len(self.states), len(self.states)))

    @cached_property
    def B(self) -> sympy.Matrix:
        """The derivatives of f by u, (n, m), at the operating point."""
        return self._system.block("B", (len(self.states), len(self.inputs)))

    @cached_property
    def C(self) -> sympy.Matrix:
        """The derivatives of g by x, (p, n), at the operating point."""
        return self._system.block("C", (len(self.outputs), len(self.states)))

    @cached_property
    def D(self) -> sympy.Matrix:
        """The derivatives of g by u, (p, m), at the operating point."""
        return self._system.block("D", (len(self.outputs), len(self.inputs)))

    def rates_by(self, parameter: str) -> sympy.Matrix:
        """Differentiate f by a parameter at constant x and u, (n, 1).

        What follows from the parameter (`dependent`) changes with it.

        Raises
        ------
        BgError
            BG079 where there is no such parameter.
        """
        self._require_parameter(parameter)
        nodes = [s.derivative for s in self._system.program.states]
        return sympy.Matrix(self._system.derivatives(nodes, parameter))

    def outputs_by(self, parameter: str) -> sympy.Matrix:
        """Differentiate g by a parameter at constant x and u, (p, 1), as `rates_by` does f."""
        self._require_parameter(parameter)
        nodes = [o.node for o in self._system.program.observations]
        return sympy.Matrix(self._system.derivatives(nodes, parameter))

    def _require_parameter(self, name: str) -> None:
        known = [symbol.name for symbol in self.parameters]
        if name not in known:
            raise BgError([catalogue.unknown_letter(name, known)])

    # --- operating points ---------------------------------------------------------------------

    def at(self, point: Mapping[str, Value]) -> SymbolicModel:
        """Choose the operating point: the same model with values for some of its letters.

        A, B, C, D and transfer functions are at the point; f, g and M stay those of any state.

        Parameters
        ----------
        point
            Numbers, SI, or SymPy expressions for states, inputs, parameters or `time` by name.
            `sym.start` has the initial values, `sym.equilibrium()` those of an equilibrium. With
            expressions, letters that are positive in the scene are taken as positive.

        Raises
        ------
        BgError
            BG079 where a letter does not exist.

        Examples
        --------
        >>> sym.at({"tank.q": sympy.Symbol("V0")}).A  # doctest: +SKIP
        >>> sym.at(sym.start).transfer("tip", "push.e")  # doctest: +SKIP
        """
        found = {str(name): exact(value) for name, value in point.items()}
        known = [symbol.name for symbol in self._system.letters.all]
        unknown = [name for name in found if name not in known]
        if unknown:
            raise BgError([catalogue.unknown_letter(name, known) for name in unknown])
        everything = {**self._point, **found}
        return SymbolicModel(
            self._path, self._options, self._inputs, self._outputs, self._given, everything
        )

    def equilibrium(
        self, near: Mapping[str, float] | None = None
    ) -> dict[sympy.Symbol, sympy.Expr]:
        """Solve `0 = f(x, u, p)` for the states, in letters.

        Letters that are positive in the scene are taken as positive in roots of squares.

        Parameters
        ----------
        near
            Numbers for states, SI: of several solutions the nearest is taken, by the scene's
            values. By default the initial state.

        Raises
        ------
        BgError
            BG099 where no formula is found.

        Examples
        --------
        >>> sym.at(sym.equilibrium()).A  # doctest: +SKIP
        """
        numbers = {**self.values, **{sympy.Symbol(n): x for n, x in (near or {}).items()}}
        try:
            return solve_equilibrium(list(self.f), self.states, numbers)
        except NoFormula as problem:
            names = [symbol.name for symbol in problem.states]
            raise BgError([catalogue.no_formula_of_equilibrium(names)]) from None

    # --- transfer functions -------------------------------------------------------------------

    def transfer(self, output: str, input: str) -> sympy.Expr:
        """The transfer function of an output by an input, a rational function of `laplace`.

        The same as `transfer_function(output, input).expression`.
        """
        return self.transfer_function(output, input).expression

    def transfer_function(self, output: str, input: str) -> TransferFunction:
        """The transfer function of an output by an input, with its poles, zeros and static gain.

        It is that of the linear form at the operating point. Where the form of a nonlinear model
        depends on states, these are letters in it, unless `at` has given them values.

        Parameters
        ----------
        output
            A name that the scene observes, or any scalar expression: `"loop.f"`, `"2*load.f"`.
        input
            A source's effort or flow (`"supply.e"`), a parameter, or a device's channel. It need
            not be among `inputs`.

        Raises
        ------
        BgError
            BG080 where the input does not exist, BG094 where the function is too large, BG096
            or BG097 where there is none at the operating point.
        """
        pair = (output, input)
        if pair not in self._functions:
            self._functions[pair] = self._transfer_function(output, input)
        return self._functions[pair]

    def _transfer_function(self, output: str, input_: str) -> TransferFunction:
        opened = self._open([input_], [output], total=True)
        program = opened.program
        for option, text, names in (
            ("input", input_, [v.name for v in opened.inputs]),
            ("output", output, [o.name for o in program.observations]),
        ):
            if len(names) != 1:
                raise BgError([analysis.several_components(option, text, names)])
        system = SymbolicSystem(opened, self._point)
        what = f"the transfer function of `{output}` by `{input_}`"

        def refused() -> BgError:
            measure = f"{len(program.states)} states, {len(program.parameters)} parameters"
            limit = f"{MOST_PRODUCTS:,} products of terms and {MOST_TERMS:,} terms, about 10 s"
            return BgError([catalogue.too_large(what, measure, limit)])

        budget = Budget(MOST_PRODUCTS, MOST_TERMS, refused)
        try:
            ratio = factored(transfer_ratio(system.linear_system(what), 0, 0, budget))
        except SingularPencil as problem:
            undetermined = [program.states[k].name for k in problem.undetermined]
            raise BgError([catalogue.undetermined(undetermined)]) from None
        except ZeroDivisionError:
            raise BgError([catalogue.undefined_at(what)]) from None
        (observation,), (varied,) = program.observations, opened.inputs
        return TransferFunction(
            output=observation.name,
            input=varied.name,
            unit=quotient_unit(observation.unit, varied.unit),
            laplace=system.letters.laplace,
            values=system.numbers(),
            units=system.letters.units,
            dependent=system.dependent,
            follows={**system.dependent, **system.given(), **system.start(ratio.symbols)},
            ratio=ratio,
        )
