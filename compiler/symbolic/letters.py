"""The letters of a model: SymPy symbols with the names of its parameters, states and inputs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import sympy

from bgc.algebra.dag import Kind, Symbol
from bgc.ir.defaults import selector_values
from bgc.ir.program import Program
from bgc.linearising.analysis_scene import Opened, channel_names
from bgc.printing.latex_names import latex_names

TIME = "time"


class Letters:
    """SymPy symbols for the symbols of an opened program.

    They are plain (`sympy.Symbol("motor.R")`, without assumptions), so that a symbol made by its
    name is the same one. The Laplace variable is `s`, with a stroke below for each name of the
    model that is the same (`s_`). An input that is a parameter is the parameter's letter.
    """

    def __init__(self, opened: Opened) -> None:
        program = opened.program
        self.parameters = tuple(sympy.Symbol(p.name) for p in program.parameters)
        self.states = tuple(sympy.Symbol(s.name) for s in program.states)
        self.inputs = tuple(sympy.Symbol(v.name) for v in opened.inputs)
        self.held = tuple(sympy.Symbol(held.name) for held in program.held)
        self.time = sympy.Symbol(TIME)
        found = [(x.name, x.unit) for x in opened.inputs]
        found += [(x.name, x.unit) for x in program.states]
        found += [(x.name, x.unit) for x in program.held]
        found += [(x.name, x.unit) for x in program.parameters]
        self.units = {sympy.Symbol(name): unit for name, unit in (*found, (TIME, "s"))}
        self._of_input = _inputs_by_index(opened)
        self._selectors = selector_values(program)
        taken = {symbol.name for symbol in self.all}
        laplace = "s"
        while laplace in taken:
            laplace += "_"
        self.laplace = sympy.Symbol(laplace)

    @property
    def all(self) -> tuple[sympy.Symbol, ...]:
        """Parameters, states, inputs, sampled values, time: as products are written."""
        letters = (*self.parameters, *self.states, *self.inputs, *self.held, self.time)
        return tuple(dict.fromkeys(letters))

    def of(self, symbol: Symbol) -> sympy.Expr:
        """The expression that stands for a symbol of the program."""
        match symbol.kind:
            case Kind.PARAM:
                return self.parameters[symbol.index]
            case Kind.STATE:
                return self.states[symbol.index]
            case Kind.TIME:
                return self.time
            case Kind.SELECTOR:
                return sympy.Integer(int(self._selectors[symbol]))
            case _:
                return self._of_input[symbol.index]


def _inputs_by_index(opened: Opened) -> Mapping[int, sympy.Expr]:
    """A letter for each INPUT symbol; zero for one added to a parameter, or of a removed value."""
    program: Program = opened.program
    found: dict[int, sympy.Expr] = dict.fromkeys(range(program.inputs), sympy.Integer(0))
    for device in program.devices:
        for k, name in enumerate(channel_names(device.name, device.inputs), device.first_input):
            found[k] = sympy.Symbol(name)
    found.update((held.index, sympy.Symbol(held.name)) for held in program.held)
    for varied in opened.inputs:
        if varied.kind != "channel":
            symbol = sympy.Symbol(varied.name)
            found[varied.index] = sympy.Integer(0) if varied.kind == "parameter" else symbol
    return found


def latex_letters(symbols: Iterable[sympy.Symbol]) -> dict[sympy.Symbol, str]:
    """The LaTeX of some symbols, each different from the others."""
    by_name = {symbol.name: symbol for symbol in symbols}
    return {by_name[name]: text for name, text in latex_names(by_name).items()}


def positive_letters(numbers: Mapping[sympy.Symbol, float]) -> dict[sympy.Symbol, sympy.Dummy]:
    """Stand-ins that SymPy knows to be positive, for letters with a positive number."""
    return {x: sympy.Dummy(x.name, positive=True) for x, value in numbers.items() if value > 0}
