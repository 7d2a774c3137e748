"""A model evaluated at a point: rates, Jacobian, modes and outputs at a state and a time."""

from __future__ import annotations

from collections.abc import Mapping

from bgc.diagnostics.public import public_class
from bgc.diagnostics.python_warnings import announce
from bgc.runtime.linear.state_space import Mode, modes_of, pencil_eigenvalues
from bgc.runtime.results.arrays import Array, Complex
from bgc.runtime.running.arguments import seconds_of
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.failures import require
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameters import ParameterValue
from bgc.runtime.running.quantity import Quantity
from bgc.runtime.running.run_warnings import turned_negative
from bgc.runtime.running.simulate import state_after


@public_class
class EvaluatedModel(LoadedModel):
    """A model with the methods that evaluate it once; see `bgc.runtime.model.Model`.

    They return bare numbers: their warnings are those of Python, a `bgc.BgWarning` each.
    """

    def initial_state(self, parameters: Mapping[str, ParameterValue] | None = None) -> Array:
        """The state at time 0, (n,), SI, in the order of `states`.

        `parameters` are values for this call alone, SI numbers or texts with a unit.
        """
        return self._announced(None, 0.0, parameters).state.copy()

    def rhs(
        self,
        state: Array | None = None,
        time: Quantity = 0.0,
        parameters: Mapping[str, ParameterValue] | None = None,
    ) -> Array:
        """Evaluate f of `M y' = f(t, y)`, (n,), SI. M is 1 in models without implicit equations.

        Parameters
        ----------
        state
            y, (n,), SI, in the order of `states`; by default the initial state.
        time
            t, s. Devices and sampled controllers have their values at the start.
        parameters
            Values for this call alone, SI numbers or texts with a unit.

        Raises
        ------
        BgError
            A wrong number of states, a parameter at fault, or a division by zero at this point.

        Examples
        --------
        >>> rates = model.rhs(model.initial_state(), "2 s")  # doctest: +SKIP
        >>> dict(zip([state.name for state in model.states], rates))  # doctest: +SKIP
        """
        instance = self._announced(state, time, parameters)
        status, f = instance.rhs()
        require(instance, status)
        return f

    def jacobian(
        self,
        state: Array | None = None,
        time: Quantity = 0.0,
        parameters: Mapping[str, ParameterValue] | None = None,
    ) -> Array:
        """Evaluate df/dy, (n, n), SI: row i has the derivatives of f[i], exact to rounding.

        `state`, `time`, `parameters` and errors are those of `rhs`.
        """
        instance = self._announced(state, time, parameters)
        status, dense, _ = instance.jacobian()
        require(instance, status)
        return dense

    def observe(
        self,
        state: Array | None = None,
        time: Quantity = 0.0,
        parameters: Mapping[str, ParameterValue] | None = None,
    ) -> dict[str, float]:
        """Evaluate the observed quantities, SI, by name; energy accounts are not among them.

        `state`, `time`, `parameters` and errors are those of `rhs`.
        """
        instance = self._announced(state, time, parameters)
        status, values = instance.outputs()
        require(instance, status)
        pairs = zip(self.measured, values.tolist(), strict=True)
        return {v.name: value for v, value in pairs if v.name in self.facts.columns}

    def eigenvalues(
        self,
        state: Array | None = None,
        time: Quantity = 0.0,
        parameters: Mapping[str, ParameterValue] | None = None,
    ) -> Complex:
        """Compute the eigenvalues of the emitted Jacobian, (n,), 1/s, by rising real part.

        Of implicit equations they are the finite ones of the pencil (df/dy, M). `state`, `time`,
        `parameters` and errors are those of `rhs`.
        """
        instance = self._announced(state, time, parameters)
        status, dense, _ = instance.jacobian()
        require(instance, status)
        status, mass = instance.mass()
        require(instance, status)
        return pencil_eigenvalues(dense, mass)

    def modes(
        self,
        state: Array | None = None,
        time: Quantity = 0.0,
        parameters: Mapping[str, ParameterValue] | None = None,
    ) -> tuple[Mode, ...]:
        """Compute the modes of the emitted Jacobian, by rising frequency.

        A pair of conjugate eigenvalues is one mode. `linearise().modes()` has the states that
        take part too. `state`, `time`, `parameters` and errors are those of `rhs`.
        """
        return modes_of(self.eigenvalues(state, time, parameters))

    def state_at(self, time: Quantity) -> tuple[Array, Array]:
        """Run to a time, s; return the state and the device inputs then. No rows are kept.

        What a result would have in `warnings`, a `bgc.BgWarning` says; energies are not examined.
        """
        reached = state_after(self, seconds_of(time, "time") or 0.0)
        announce(reached.warnings)
        return reached.state, reached.inputs

    def _announced(
        self, state: Array | None, time: Quantity, parameters: Mapping[str, ParameterValue] | None
    ) -> Instance:
        """An instance at a point, after warnings of its parameters."""
        instance = self.instance_at(state, seconds_of(time, "time") or 0.0, parameters)
        announce(turned_negative(self, instance))
        return instance
