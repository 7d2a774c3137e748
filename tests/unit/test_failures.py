"""Statuses of the C runtime in the user's words."""

from types import SimpleNamespace

import pytest
from refusals import refusal

import bgc
from bgc.building.build_result import Place, Places
from bgc.diagnostics.source import Source, Span
from bgc.driver import check_source
from bgc.runtime.running.failures import explain
from bgc.runtime.running.structures import Status

MODEL = SimpleNamespace(
    state=[SimpleNamespace(name=b"coil.p")],
    assertion=[b"too far"],
    divisor=[b"the common inertia of `crank` and `rod`"],
    device=[SimpleNamespace(name=b"hand")],
    n_device=1,
    n_param=0,
    n_check=1,
    param_check=[b"the inertia of `coil` must be positive"],
)
CODES = {
    Status.STEP_TOO_SMALL: "BG701",
    Status.TOO_MANY_STEPS: "BG702",
    Status.NOT_FINITE: "BG703",
    Status.SINGULAR: "BG704",
    Status.ASSERTION: "BG705",
    Status.DEVICE: "BG706",
    Status.BAD_PARAMETER: "BG707",
    Status.NO_MEMORY: "BG708",
    Status.INTERRUPTED: "BG709",
    Status.NOT_EXPLICIT: "BG710",
    Status.INCONSISTENT: "BG711",
    Status.NOT_CONVERGED: "BG714",
    Status.CHATTERING: "BG715",
    Status.VANISHING: "BG725",
    Status.SINGULAR_CHAIN: "BG735",
    Status.OPEN_CHAIN: "BG736",
    Status.ENDLESS_JUMPS: "BG770",
    Status.BAD_SAMPLE: "BG771",
    Status.GRAZING: "BG785",
    Status.SIMULTANEOUS: "BG786",
    Status.FMU: "BG673",
}


def instance(**places):
    at = {"device": -1, **places}
    return SimpleNamespace(
        library=SimpleNamespace(model=MODEL, fmus=[SimpleNamespace(file="lag.fmu", name="lag")]),
        time=1.5,
        given={},
        failed=lambda what: at.get(what, 0),
        device_reason="",
        fmu_reason="no step of 7 s",
        failed_time=1.25,
        chain_position={"pin.angle": 0.25},
        failed_chain="crank, rod",
        failed_condition="weld.gap[1]",
    )


@pytest.mark.parametrize("status", CODES, ids=lambda status: status.name)
def test_each_status_has_its_diagnostic_and_a_way_out(status):
    diagnostic = explain(instance(), status)
    assert diagnostic.code == CODES[status]
    assert diagnostic.help or status is Status.INTERRUPTED


def test_every_status_that_a_user_can_meet_is_covered():
    assert set(Status) - set(CODES) == {Status.OK, Status.BAD_ARGUMENT}


def test_the_time_the_state_and_the_models_own_words_are_named():
    assert "1.5 s" in explain(instance(), Status.NOT_FINITE).message
    assert "coil.p" in explain(instance(), Status.NOT_FINITE).message
    assert "state" not in explain(instance(state=-1), Status.NOT_FINITE).message
    assert "too far" in explain(instance(), Status.ASSERTION).message
    assert explain(instance(), Status.SINGULAR_CHAIN).note == "there `pin.angle` = 0.25"
    assert "inertia of `coil`" in explain(instance(), Status.BAD_PARAMETER).message


def test_failed_assertions_and_chattering_laws_are_shown_in_the_source():
    source = Source("a.bg", "assert x < 1;\ne = sign(f);\n")
    places = Places(
        assertions=(Place(Span(source, 0, 13)),),
        switches=(Place(Span(source, 18, 25), ("mass.p",)),),
    )
    failed = explain(instance(), Status.ASSERTION, places)
    assert failed.span is not None and failed.span.text == "assert x < 1;"
    chattering = explain(instance(), Status.CHATTERING, places)
    assert chattering.span is not None and chattering.span.text == "sign(f)"
    assert "mass.p" in chattering.message


def test_a_divisor_that_vanishes_is_named_with_its_time_and_its_states():
    source = Source("a.bg", "rod : I(2 kg);\n")
    places = Places(divisors=(Place(Span(source, 0, 3), ("crank.angle",)),))
    vanishing = explain(instance(), Status.VANISHING, places)
    for part in ("1.25 s", "the common inertia of `crank` and `rod`", "`crank.angle`"):
        assert part in vanishing.message
    assert vanishing.span is not None and vanishing.span.text == "rod"


def test_initial_values_that_the_parameters_put_out_of_reach():
    failed = instance(parameter=1)  # n_param + n_check
    diagnostic = explain(failed, Status.BAD_PARAMETER, Places(start=("leak", "core")))
    assert diagnostic.code == "BG732"
    assert "of `leak` and `core` hold" in diagnostic.message


@pytest.mark.parametrize(
    ("names", "words"),
    [([b"hand"], "device `hand` reported"), ([b"hand", b"foot"], "devices `hand` and `foot`")],
)
def test_a_fault_names_the_devices_that_may_have_reported_it(names, words):
    faulty = instance()
    faulty.library = SimpleNamespace(
        model=SimpleNamespace(device=[SimpleNamespace(name=n) for n in names], n_device=len(names))
    )
    assert words in explain(faulty, Status.DEVICE).message
    faulty.failed, faulty.device_reason = lambda what: len(names) - 1, "no\x1b answer"
    named = f"device `{names[-1].decode()}` reported"
    message = explain(faulty, Status.DEVICE).message
    assert named in message and message.endswith(r": no\x1b answer")


@pytest.mark.parametrize(
    ("driver", "words"), [("omega", "one of its drivers: `"), ("trcae", "mean `trace`")]
)
def test_an_unknown_driver_is_answered_with_those_of_the_build(tmp_path, driver, words):
    path = tmp_path / "m.bg"
    path.write_text(
        "model M { input v = 0; state x = 1; der(x) = v; }\n"
        f"scene s of M {{ device hand = {driver}(); drive v = hand.position[1]; run 1 s; }}"
    )
    diagnostic = refusal(lambda: bgc.compile(path).simulate())
    assert diagnostic.code == "BG073" and words in diagnostic.help
    (checked,) = check_source(path)
    assert checked.message == diagnostic.message and checked.help == diagnostic.help
    assert checked.span is not None and checked.span.text.startswith("device hand")


@pytest.mark.parametrize("solver", ["ode45", "rodas5", "auto", "rk4", "cvode"])
def test_a_check_knows_the_methods_of_a_run(tmp_path, solver):
    path = tmp_path / "m.bg"
    path.write_text(
        "model M { state x = 1; der(x) = -x; }\n"
        f"scene s of M {{ observe x; solver {solver}; step 1 ms; run 1 s; }}"
    )
    found = [(d.code, d.span.text) for d in check_source(path)]
    assert found == ([] if solver in ("auto", "rk4", "cvode") else [("BG071", f"solver {solver}")])
