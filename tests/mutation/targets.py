"""Sources that are broken, and the test files that are run against them.

Which of these files execute a broken line is measured, so none is assigned to a source by hand.
Names without a folder are in tests/unit; `p/` stands for tests/physics, `./` for tests.
"""

from __future__ import annotations

C_FOLDERS = ("runtime/c", "runtime/c/lanes")
PYTHON_FOLDER = "compiler/equations"

WHOLE = {
    "runtime/c/fmi": ["tests/unit/test_fmi.py"],
    "runtime/c/servo": [
        "tests/unit/test_realtime.py",
        "-k=replays or fault_ends or patient or first_sample or absent or limits_of or dead_mans"
        " or normal_stop or takes_the_place or refused or disk or may_not_grow or refuses or news",
    ],
}
"""Folders whose breaks `whole.py` tries, and arguments of pytest: without the tests of lateness."""

TESTS = """
asserts attacks audit blocks block_models control definite determined divisors energy_accounts
ensemble ensemble_events equations failures fast_modes free_motions impulses initial_defaults
input_variation inputs invariants jumps linear lockstep loops model number_range numerics_devices
numerics_events numerics_linear numerics_methods numerics_runs numerics_stiffness numerics_substeps
numerics_tableaus observables random ranges realtime rounding rows rows_between_events sampled
sparse state_names switches switching windows symbolic identity solution_check

p/accounts p/actuators p/arms p/chosen p/closed_chains p/closing p/coarse_steps p/coupling
p/dead_centres p/drives p/events p/faint p/faint_motions p/four_bar p/hidden
p/ic_fields p/ivp p/joints p/jumps p/kinks p/limits_of_steps p/linkages p/long_chains p/loops
p/mechanism p/merged p/monotone_loops p/mounted_arms p/pairs p/pulse p/pulses p/random_arms
p/rate_loops p/reactions p/rest p/rigid_crane p/sampled p/sampled_ports p/settling p/splash
p/reset p/starts p/stiffening p/substeps p/timed p/trains p/two_point p/typologies p/undefined
./wrong_models
""".split()


def test_file(name: str) -> str:
    """The path of a test file."""
    if name.startswith("./"):
        return f"tests/test_{name[2:]}.py"
    folder, base = ("physics", name[2:]) if name.startswith("p/") else ("unit", name)
    return f"tests/{folder}/test_{base}.py"
