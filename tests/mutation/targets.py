"""The tests that each file's breaks are run against, quickest and most decisive first.

Names without a folder are in tests/unit; `p/` stands for tests/physics.
"""

from __future__ import annotations

_METHODS = ("numerics_methods", "numerics_tableaus", "numerics_runs")
_EVENTS = ("numerics_events", "numerics_methods", "p/events", "p/kinks")
_CHAINS = ("p/four_bar", "p/dead_centres", "p/linkages", "p/closed_chains", "p/closing")

C = {
    "accounts": ("numerics_methods", "numerics_runs", "energy_accounts", "p/accounts"),
    "closures": _CHAINS,
    "collocation": (*_METHODS, "p/ivp"),
    "complex": ("numerics_linear", "numerics_methods", "p/ivp"),
    "consistent": ("numerics_runs", "numerics_methods", "p/loops", "attacks", "failures"),
    "corrections": ("numerics_methods", "p/coarse_steps"),
    "dense": ("numerics_methods", "numerics_runs", "numerics_events"),
    "devices": ("numerics_devices",),
    "divisors": ("p/undefined", "p/dead_centres", "failures"),
    "evaluate": ("asserts", "numerics_runs"),
    "events": _EVENTS,
    "explicit": _METHODS,
    "faint": ("p/faint",),
    "first_step": ("numerics_methods", "numerics_runs", "p/ivp"),
    "instance": ("numerics_runs", "numerics_devices", "numerics_events"),
    "least_squares": ("p/loops", "p/starts", "attacks"),
    "linear": ("numerics_linear", "numerics_methods"),
    "modes": _EVENTS,
    "options": ("numerics_runs", "numerics_methods", "numerics_devices", "numerics_substeps"),
    "rosenbrock": _METHODS,
    "rounding": ("p/limits_of_steps",),
    "run": ("numerics_runs", "numerics_devices", "numerics_methods"),
    "save": ("numerics_runs", "numerics_devices"),
    "sparse": ("sparse", "numerics_linear", "numerics_methods"),
    "stages": _METHODS,
    "start": ("p/starts", "p/closing", "p/settling"),
    "step": ("numerics_methods", "numerics_runs", "numerics_events", "numerics_substeps",
             "p/limits_of_steps", "p/coarse_steps", "failures"),
    "stiffness": ("numerics_stiffness",),
    "substeps": ("numerics_substeps", "p/substeps"),
    "tableaus": ("numerics_tableaus", "numerics_methods"),
    "timed": ("p/timed", "p/pulses", "p/pulse"),
    "vectors": ("numerics_methods", "numerics_runs"),
    "watch": ("p/hidden",),
}  # fmt: skip

_EQUATIONS = ("equations", "invariants", "energy_accounts", "loops")
PYTHON = {
    "closures": ("p/four_bar", "p/linkages", "p/closing", "p/closed_chains", "definite"),
    "inertias": ("equations", "p/merged", "p/reactions", "p/joints", "p/starts", "definite",
                 "p/arms", "p/random_arms", "impulses"),
    "loops": ("loops", "equations", "p/loops", "p/rate_loops", "p/monotone_loops",
              "p/typologies", "determined"),
    "motions": ("free_motions", "equations", "p/merged", "p/stiffening", "p/starts", "fast_modes",
                "p/faint_motions", "p/mechanism"),
    "start": ("initial_defaults", "p/starts", "p/closing", "equations", "p/settling"),
    "storage": (*_EQUATIONS, "initial_defaults", "p/accounts", "p/ic_fields", "identity"),
    "variables": (*_EQUATIONS, "elaborate_errors", "state_names", "p/typologies"),
    "": (*_EQUATIONS, "impulses", "audit", "ranges", "number_range", "scale"),
}  # fmt: skip


def test_file(name: str) -> str:
    """The path of a test file."""
    folder, base = ("physics", name[2:]) if name.startswith("p/") else ("unit", name)
    return f"tests/{folder}/test_{base}.py"
