"""Linearise a scene about an operating point: the start, a time, or an equilibrium."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.building.build_result import run_facts
from bgc.building.cache import digest_of, open_cache
from bgc.diagnostics.catalogue import analysis, run, samples
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.driver import build_model, compile_scene
from bgc.emission.emit import emit_model
from bgc.ir.defaults import program_values
from bgc.ir.graph import Node
from bgc.linearising.analysis_scene import Opened, open_scene
from bgc.linearising.linear_form import LinearForm, linear_form
from bgc.options import Options
from bgc.record_class import dataclass, replace
from bgc.runtime.linear.equilibrium import Tangent, find_equilibrium, find_zero
from bgc.runtime.linear.state_space import (
    Linearisation,
    Mode,
    modes_with_vectors,
    without_algebraic,
)
from bgc.runtime.linearising.chains import ClosedChains
from bgc.runtime.results.arrays import Array, Complex
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.simulate import state_after

Mask: TypeAlias = NDArray[np.bool_]

_AT_REST = 1e-8  # of a state's scale per second, or of the largest rate at the start


@dataclass(frozen=True, slots=True)
class OperatingPoint:
    """Time, s, and values of the states and INPUT symbols of the opened program, SI."""

    time: float
    state: Array
    inputs: Array
    warnings: tuple[Diagnostic, ...] = ()  # about the run to this point


class OpenedModel:
    """An opened scene with numbers for its parameters, to evaluate it and its derivatives.

    `values`, SI, replace the parameter values of the file and of `options`.
    """

    def __init__(
        self,
        path: Path,
        options: Options,
        inputs: Sequence[str] = (),
        outputs: Sequence[str] = (),
        values: Mapping[str, float] | None = None,
    ) -> None:
        self._path, self._options, self._values_given = path, options, dict(values or {})
        self._folder = path.absolute().parent
        self.opened: Opened = open_scene(path, options, inputs, outputs, values)
        self._form: LinearForm = linear_form(self.opened)
        program = self.opened.program
        self._parameters = program_values(program)
        self._chains = ClosedChains(program, [v.index for v in self.opened.inputs])
        scale = self._numbers([s.scale for s in program.states], self._parameters)
        self.scale = np.where(scale > 0, scale, 1.0)

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """Warnings of the compiler."""
        return self.opened.warnings

    # --- operating points ---------------------------------------------------------------------

    def operating_point(self, at: float | Literal["steady"] | None) -> OperatingPoint:
        """Find the state at a time in s, or in equilibrium; by default the initial state."""
        if at is None:
            return self.at_start()
        return self.steady() if at == "steady" else self.at_time(at)

    def at_start(self) -> OperatingPoint:
        """Find the initial state with zero device inputs, and solve algebraic equations."""
        program = self.opened.program
        inputs = np.zeros(program.inputs)
        nothing = OperatingPoint(0.0, np.zeros(len(program.states)), inputs)
        held = self._numbers([h.initial for h in program.held], self._values(nothing))
        inputs[[h.index for h in program.held]] = held
        state = self._numbers([s.initial for s in program.states], self._values(nothing))
        state = self._at_rest(state, [s.name for s in program.states])
        point = self.projected(OperatingPoint(0.0, state, inputs))
        in_mass = self.mass() != 0
        rows = np.logical_not(np.logical_or.reduce(in_mass, axis=1))
        columns = np.logical_not(np.logical_or.reduce(in_mass, axis=0))
        if not rows.any():
            return point
        block = _Block(self, point, rows, columns)
        return block.solved(*find_zero(block.rates, block.slope, block.start))

    def _at_rest(self, state: Array, state_names: Sequence[str]) -> Array:
        """The initial state, or that of the scene's start at rest; by the names of the states."""
        if not self.opened.starts_at_rest:
            return state
        options = replace(self._options, whole=True, observe=())
        model = LoadedModel(compile_scene(self._path, options).built, self._folder)
        instance = model.instance_at(None, 0.0, self._values_given)
        found = dict(zip((s.name for s in model.states), instance.state.tolist(), strict=True))
        pairs = zip(state_names, state.tolist(), strict=True)
        return np.array([found.get(name, value) for name, value in pairs])

    def at_time(self, time: float) -> OperatingPoint:
        """Simulate to a time, s; take the state and the device inputs then."""
        program = self.opened.moving
        emitted = emit_model(program, digest_of(self.opened.sources))
        built = build_model(emitted, run_facts(program.scene), Options(), (), open_cache())
        model = LoadedModel(built, self._folder)
        start = None
        if self.opened.starts_at_rest:
            names = [variable.name for variable in program.states]
            start = self._at_rest(model.instance_at(None, 0.0, {}).state.copy(), names)
        reached = state_after(model, time, start)
        place = {variable.name: k for k, variable in enumerate(program.states)}
        places = [place[variable.name] for variable in self.opened.program.states]
        return OperatingPoint(time, reached.state[places], reached.inputs, reached.warnings)

    def steady(self) -> OperatingPoint:
        """Find the equilibrium that the initial state leads to; BG082 if there is none.

        BG772 in a model with sampled parts, whose values would have to be found too.
        """
        if self.opened.program.held:
            raise BgError([samples.steady_of_sampled([h.name for h in self.opened.program.held])])
        point = self.at_start()
        every = np.ones(len(point.state), dtype=bool)
        block = _Block(self, point, every, every)
        found = find_equilibrium(
            block.rates, block.slope, block.mass, block.start, block.projected, block.tangent
        )
        return block.solved(*found)

    def at_state(self, state: Mapping[str, float], time: float) -> OperatingPoint:
        """Take some values by name, and the others from the initial state."""
        start = self.at_start()
        states = self.opened.program.states
        values = [state.get(s.name, x) for s, x in zip(states, start.state, strict=True)]
        return OperatingPoint(time, np.array(values), start.inputs)

    # --- values at a point --------------------------------------------------------------------

    def linearise(self, point: OperatingPoint) -> Linearisation:
        """Compute the derivatives at a point, and eliminate algebraic equations if possible."""
        program, opened = self.opened.program, self.opened
        n, p, m = len(program.states), len(program.observations), len(opened.inputs)
        values = self._values(point)
        by_state = self._dense(self._form.by_state, (n + p, n), values)
        by_input = self._dense(self._form.by_input, (n + p, m), values)
        if not np.isfinite(by_state).all() or not np.isfinite(by_input).all():
            raise BgError([run.not_finite(point.time, None)])
        follow, free = self.coordinates(point)
        A, B, C, D, E, left = without_algebraic(
            by_state[free] @ follow,
            by_input[free],
            by_state[n:] @ follow,
            by_input[n:],
            self.mass()[free] @ follow,
        )
        left = free[left]
        states = [program.states[k] for k in left]
        named = (*states, *opened.inputs, *program.observations)
        return Linearisation(
            A, B, C, D, E,
            states=tuple(s.name for s in states),
            inputs=tuple(v.name for v in opened.inputs),
            outputs=tuple(o.name for o in program.observations),
            units={x.name: x.unit for x in named},
            point=point.state[left],
            time=point.time,
            shown={s.name: s.shown for s in states if s.shown is not None},
            warnings=(*self.warnings, *point.warnings),
        )  # fmt: skip

    def mode_shapes(self, point: OperatingPoint) -> tuple[tuple[Mode, ...], Complex]:
        """Compute the modes at a point, and the changes of all states in them, (n, modes), SI.

        The eigenvector of each mode, with the states that algebraic equations and closed chains
        determine; one of each conjugate pair, by rising frequency.
        """
        n = len(self.opened.program.states)
        by_state = self.by_state(point)
        follow, free = self.coordinates(point)
        A, _, C, _, E, left = without_algebraic(
            by_state[free] @ follow,
            np.empty((len(free), 0)),
            follow,
            np.empty((n, 0)),
            self.mass()[free] @ follow,
        )
        names = [self.opened.program.states[k].name for k in free[left]]
        modes, vectors = modes_with_vectors(A, E, names)
        return modes, C @ vectors

    def coordinates(self, point: OperatingPoint) -> Tangent:
        """Choose independent states: all of them where there are no closed chains."""
        n = len(self.opened.program.states)
        return self._chains.coordinates(self._values(point), n, self.scale)

    def _values(self, point: OperatingPoint) -> dict[Symbol, float]:
        values = dict(self._parameters)
        values[Symbol(Kind.TIME, 0)] = point.time
        values.update((Symbol(Kind.STATE, k), x) for k, x in enumerate(point.state.tolist()))
        values.update((Symbol(Kind.INPUT, k), x) for k, x in enumerate(point.inputs.tolist()))
        return values | self._chains.selection(values)

    def _numbers(self, nodes: Sequence[Node], values: Mapping[Symbol, float]) -> Array:
        return np.array(evaluate_nodes(self._form.dag, nodes, values), dtype=float)

    def rates(self, point: OperatingPoint) -> Array:
        """Evaluate the right-hand sides f of M x' = f."""
        return self._numbers(self._form.rates, self._values(point))

    def outputs(self, point: OperatingPoint) -> Array:
        """Evaluate the outputs."""
        return self._numbers(self._form.outputs, self._values(point))

    def by_state(self, point: OperatingPoint) -> Array:
        """Evaluate df/dx, dense."""
        n = len(self.opened.program.states)
        entries = [entry for entry in self._form.by_state if entry[0] < n]
        return self._dense(entries, (n, n), self._values(point))

    def _dense(
        self,
        entries: Sequence[tuple[int, int, Node]],
        shape: tuple[int, int],
        values: Mapping[Symbol, float],
    ) -> Array:
        """Evaluate a sparse matrix."""
        dense = np.zeros(shape)
        numbers = self._numbers([node for _, _, node in entries], values)
        for (row, column, _), value in zip(entries, numbers, strict=True):
            dense[row, column] = value + 0.0  # no negative zeros
        return dense

    def mass(self) -> Array:
        """Evaluate M, dense."""
        program = self.opened.program
        if program.mass is None:
            return np.eye(len(program.states))
        entries = [(entry.row, entry.column, entry.value) for entry in program.mass]
        return self._dense(entries, (len(program.states),) * 2, self._parameters)

    def projected(self, point: OperatingPoint) -> OperatingPoint:
        """Project the states that a run projects after each step."""
        projections = [
            (k, s.projection)
            for k, s in enumerate(self.opened.program.states)
            if s.projection is not None
        ]
        state = point.state.copy()
        if projections:
            state[[k for k, _ in projections]] = self._numbers(
                [node for _, node in projections], self._values(point)
            )
        near = OperatingPoint(point.time, state, point.inputs)
        state = self._chains.closed(self._values(near), state)
        return OperatingPoint(point.time, state, point.inputs)


class _Block:
    """Some right-hand sides as functions of some of the states, in units of the states' scales."""

    def __init__(
        self, model: OpenedModel, point: OperatingPoint, rows: Mask, columns: Mask
    ) -> None:
        self._model, self._point = model, point
        self._rows, self._columns = rows, columns
        self._within = np.ix_(rows, columns)
        self._by_scale = model.scale / model.scale[:, None]
        self.start: Array = (point.state / model.scale)[columns]
        self.mass: Array = (model.mass() * self._by_scale)[self._within]
        self._allowed = _AT_REST * max(1.0, float(np.abs(self.rates(self.start)).max(initial=0.0)))

    def _moved(self, y: Array) -> OperatingPoint:
        state = self._point.state.copy()
        state[self._columns] = y * self._model.scale[self._columns]
        return OperatingPoint(self._point.time, state, self._point.inputs)

    def rates(self, y: Array) -> Array:
        """Evaluate the right-hand sides."""
        found: Array = (self._model.rates(self._moved(y)) / self._model.scale)[self._rows]
        return found

    def slope(self, y: Array) -> Array:
        """Evaluate their derivatives by the states."""
        found: Array = (self._model.by_state(self._moved(y)) * self._by_scale)[self._within]
        return found

    def projected(self, y: Array) -> Array:
        """Project the states as after a step of a run."""
        found: Array = (self._model.projected(self._moved(y)).state / self._model.scale)[
            self._columns
        ]
        return found

    def tangent(self, y: Array) -> Tangent:
        """Changes of all states by the independent ones; for a block of all states."""
        scale = self._model.scale
        along, free = self._model.coordinates(self._moved(y))
        return along * scale[free] / scale[:, None], free

    def solved(self, y: Array, remaining: Array) -> OperatingPoint:
        """Return the operating point of a solution; BG082 if right-hand sides remain."""
        if not np.abs(remaining).max(initial=0.0) <= self._allowed:
            worst = int(np.flatnonzero(self._rows)[np.argmax(np.abs(remaining))])
            state = self._model.opened.program.states[worst]
            rate = float(np.abs(remaining).max() * self._model.scale[worst])
            raise BgError([analysis.no_equilibrium(state.name, rate, state.unit)])
        return self._moved(y)
