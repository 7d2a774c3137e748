"""The integration methods of the C runtime, in its order.

This table is the source: `pytest tests/unit/test_methods.py --bless` writes its rows into
`runtime/c/tableaus.c`, beside the coefficients. The first method with error control and the first
with fixed steps are the defaults.
"""

from __future__ import annotations

from collections.abc import Mapping

from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class Family:
    """Methods whose steps one function of C takes; `variable` is its name there.

    Attributes
    ----------
    jacobian
        Whether steps use df/dx. Without, the method is explicit and M of M y' = f must be diagonal.
    lanes
        Whether several instances can take its steps together.
    """

    name: str
    variable: str
    jacobian: bool = True
    lanes: bool = False


ROSENBROCK = Family("Rosenbrock", "rosenbrock", lanes=True)
RADAU = Family("Radau IIA collocation", "radau")
GAUSS = Family("Gauss collocation", "gauss")
EXPLICIT = Family("explicit Runge-Kutta", "explicit_runge_kutta", jacobian=False, lanes=True)


@dataclass(frozen=True, slots=True)
class Method:
    """An integration method, as `bgc_method_info` of `bgc.h` describes it.

    Attributes
    ----------
    name, family
        As `rodas5p`; as `ROSENBROCK`.
    order, stages
        Order of the solution, and number of its stages.
    purpose
        A line of text: the equations and uses that it is for.
    error_order
        Order of the embedded solution that estimates the error; 0: fixed steps only.
    embedded_order
        Order of the solution by which fixed steps may be subdivided; 0: they may not.
    parts
        Most parts of a fixed step where the options give none.
    coefficients
        Variable of C with its coefficients, where it is not `name`.
    partner
        The explicit method to which it changes.
    checks_dense
        Whether the error of its dense output is checked too.
    """

    name: str
    family: Family
    order: int
    stages: int
    purpose: str
    error_order: int = 0
    embedded_order: int = 0
    parts: int = 1
    coefficients: str = ""
    partner: str = ""
    checks_dense: bool = False

    @property
    def fixed(self) -> bool:
        """Return whether its steps have a given length."""
        return self.error_order == 0


METHODS: Mapping[str, Method] = {
    method.name: method
    for method in (
        Method(
            "rodas5p",
            ROSENBROCK,
            order=5,
            stages=8,
            error_order=4,
            purpose="stiff, non-stiff and algebraic equations at medium to tight tolerances",
        ),
        Method(
            "switching",
            ROSENBROCK,
            order=5,
            stages=8,
            error_order=4,
            coefficients="rodas5p",
            partner="dopri5",
            purpose="rodas5p, and dopri5 where nothing is stiff and its steps cost less",
        ),
        Method(
            "rodas4p2",
            ROSENBROCK,
            order=4,
            stages=6,
            error_order=3,
            checks_dense=True,
            purpose="stiff and algebraic equations at loose tolerances, 1e-3 to 1e-5",
        ),
        Method(
            "radau5",
            RADAU,
            order=5,
            stages=3,
            error_order=3,
            checks_dense=True,
            purpose="very stiff equations at tight tolerances; Newton iteration in each step",
        ),
        Method(
            "ros34prw",
            ROSENBROCK,
            order=3,
            stages=4,
            embedded_order=2,
            parts=8,
            purpose="real time: stiff and algebraic equations; "
            "keeps its order with a kept Jacobian",
        ),
        Method(
            "switching_fixed",
            ROSENBROCK,
            order=3,
            stages=4,
            embedded_order=2,
            parts=8,
            coefficients="ros34prw",
            partner="rk4",
            purpose="ros34prw, and rk4 where the steps resolve every motion",
        ),
        Method(
            "rodas23w",
            ROSENBROCK,
            order=2,
            stages=4,
            embedded_order=1,
            purpose="fixed steps on algebraic equations; keeps its order with a kept Jacobian",
        ),
        Method(
            "ros23",
            ROSENBROCK,
            order=2,
            stages=2,
            embedded_order=1,
            purpose="fixed steps at low cost: two stages; keeps its order with a kept Jacobian",
        ),
        Method(
            "lie",
            ROSENBROCK,
            order=1,
            stages=1,
            purpose="linearly implicit Euler: the cheapest fixed step, strongly damped",
        ),
        Method(
            "midpoint",
            GAUSS,
            order=2,
            stages=1,
            purpose="long undamped motions: conserves the energy of linear elements",
        ),
        Method(
            "gauss4",
            GAUSS,
            order=4,
            stages=2,
            purpose="long undamped motions, as midpoint, at order 4",
        ),
        Method(
            "rk4",
            EXPLICIT,
            order=4,
            stages=4,
            embedded_order=2,
            purpose="fixed steps on non-stiff equations: classical Runge-Kutta method",
        ),
        Method(
            "heun",
            EXPLICIT,
            order=2,
            stages=2,
            embedded_order=1,
            purpose="fixed steps on non-stiff equations at low cost: two stages",
        ),
        Method(
            "dopri5",
            EXPLICIT,
            order=5,
            stages=7,
            error_order=4,
            purpose="error control on non-stiff equations: Dormand-Prince method",
        ),
    )
}
"""All methods by name."""

SWITCHING, SWITCHING_FIXED = (name for name, method in METHODS.items() if method.partner)


def default_method(fixed: bool, changes: bool = False) -> str:
    """Name the default with fixed steps or with error control: the first such method.

    With `changes` the first that changes to an explicit method where nothing is stiff.
    """
    kinds = (m for m in METHODS.values() if m.fixed == fixed)
    return next(m.name for m in kinds if m.partner or not changes)
