"""The first cases of each campaign, and the limits under which campaigns judge."""

import os
import sys
from functools import partial

import ill_posed
import mutants
import pytest
import random_programs
import variants
import workers
from judging import Verdict

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="limits the resources of a process")

MUTANTS = 300
PART = 20


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, MUTANTS, 100))
def test_mutated_files_are_answered(tmp_path, first):
    with mutants.library_parsed_once():
        portion = workers.run_portion(first, 100, partial(mutants.judge, 1), tmp_path)
    assert portion.faults == []
    assert portion.outcomes["refused"] > 50 and portion.outcomes["accepted"] > 3


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, len(ill_posed.KINDS), PART))
def test_ill_posed_models_are_refused_or_end_with_a_code(tmp_path, first):
    size = min(PART, len(ill_posed.KINDS) - first)
    portion = workers.run_portion(first, size, partial(ill_posed.judge, 1), tmp_path)
    assert portion.faults == []
    assert set(portion.outcomes) <= {"refused", "stopped", "warned"}


@pytest.mark.slow
def test_random_programs_satisfy_their_equations(tmp_path):
    portion = workers.run_portion(200004, 4, partial(random_programs.judge, 1), tmp_path)
    assert portion.faults == []
    assert portion.outcomes["agrees"] >= 3


def test_programs_without_a_verdict_are_recorded(tmp_path, monkeypatch):
    table = tmp_path / "unjudged.tsv"
    table.write_text("3\tslow\t\tabc\n5\topen\trows\tabc\n9\tdiffers\tx\tabc\n")
    monkeypatch.setattr(random_programs, "TABLE", table)
    found = workers.Portion(2, 4)  # cases 2 to 5, of which 5 is judged now
    for number, outcome in ((2, "unjust"), (3, "hang"), (4, "ill"), (5, "agrees")):
        found.note(number, Verdict(outcome, (), f"BG502\n{outcome}"))
    random_programs.record([found])
    rows = [line.split("\t")[:3] for line in table.read_text().splitlines()]
    assert rows == [["2", "unjust", "BG502 unjust"], ["3", "hang", ""], ["9", "differs", "x"]]
    assert random_programs.unjudged() == [2, 3, 9]


def test_a_case_is_the_same_each_time():
    assert [mutants.text_of(1, k) for k in range(20)] == [mutants.text_of(1, k) for k in range(20)]
    assert [random_programs.text_of(1, k) for k in range(9)] == [
        random_programs.text_of(1, k) for k in range(9)
    ]
    assert mutants.text_of(1, 3) != mutants.text_of(2, 3)
    assert [ill_posed.text_of(1, k) for k in range(9)] == [
        ill_posed.text_of(1, k) for k in range(9)
    ]


def failing(number, folder):
    """A judge whose cases fail in different ways, each followed by one that succeeds."""
    if number == 1:
        while True:
            pass
    if number == 3:
        os.abort()
    if number == 5:
        bytearray(10 * workers.MEMORY)
    return [Verdict("accepted", ("BG101",))]


def test_a_case_over_its_limits_is_a_fault_of_its_own(tmp_path, monkeypatch):
    monkeypatch.setattr(workers, "CPU_SECONDS", 0.2)
    portion = workers.run_portion(0, 7, failing, tmp_path)
    assert [(number, outcome) for number, outcome, _ in portion.faults] == [
        (1, "hang"),
        (3, "died"),
        (5, "memory"),
    ]
    assert portion.outcomes["accepted"] == portion.codes["BG101"] == 4


def test_portions_are_kept(tmp_path):
    path = tmp_path / "results.jsonl"
    portion = workers.run_portion(0, 3, lambda number, folder: [Verdict("hang")], tmp_path)
    workers.keep_portion(path, portion)
    assert workers.kept_portions(path) == {0: portion}
    assert "hang                3" in workers.summary([portion])


SPRINGS = """
model Hanging {
  param pull : N = 20 N;
  mass   : I(2 kg);
  weight : Se(e = pull);
  spring : C(stiffness = 100 N/m, q0 = 0.1 m);
  body   : J1;
  weight -> body -> mass, spring;
}
scene still of Hanging { observe spring.q as stretch; start rest; run 1 s; }
scene falling of Hanging { observe spring.q as stretch; run 1 s; }
"""


def test_a_changed_scene_that_moves_is_a_fault(tmp_path):
    (tmp_path / "scenes").mkdir()
    (tmp_path / "scenes" / "springs.bg").write_text(SPRINGS)
    found = [case for number in range(2) for case in variants.cases(tmp_path, number)]
    assert {(case.kind, case.name) for case in found} == {("set", "pull")} and len(found) == 4
    numbers = (0, 1, variants.SIZE, variants.SIZE + 1)
    outcomes = [variants.judge(1, k, tmp_path)[0].outcome for k in numbers]
    assert outcomes == ["at rest", "at rest", "silent", "silent"]
    assert variants.judge(1, 2, tmp_path) == []
