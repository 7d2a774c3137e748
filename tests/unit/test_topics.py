"""What users look for under other names: each row of `topics.md` leads to what there is."""

import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from bgc.reference.entry import Entry, Group
from bgc.reference.index import find, search
from bgc.reference.topics import topics
from bgc.runtime.cli.app import application
from bgc.runtime.cli.doc import all_groups

TABLE = Path(__file__).parents[2] / "grammar/manual/topics.md"
TOPICS = topics()
# Names in code that are of Python, or of files and paths that a row has as examples.
FOREIGN = {"arm.xml", "wall.bg", "bgc.control", "energy.residual", "source.e"}


def bgc_doc(*words: str):
    return CliRunner().invoke(application, ["doc", *words])


def test_every_row_of_the_table_is_read():
    rows = [line for line in TABLE.read_text("utf-8").splitlines() if line.startswith("| ")]
    assert len(rows) - 1 == len(TOPICS) > 50
    names = [name.casefold() for topic in TOPICS for name in topic.names]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("topic", TOPICS, ids=lambda topic: topic.names[0])
def test_what_a_topic_names_is_there(topic):
    assert topic.see_also and topic.text.endswith(".")
    for name in topic.see_also:
        assert find(name, all_groups()), name
    for code in re.findall(r"`([^`]+)`", topic.text):
        if re.fullmatch(r"[A-Z]\w+(\[\w+\])?|[a-z_]+\.[a-z_]+", code):
            name = code.partition("[")[0]
            assert find(name, all_groups()) or name in FOREIGN, name


@pytest.mark.parametrize(
    ("looked_for", "found"),
    [
        ("LQR", "solve_continuous_are"),
        ("load chart", "bgc sweep"),
        ("WAMIT", "marine.response"),
        ("Kalman", "PassiveObserver"),
        ("z-width", "haptics.coupling"),
        ("mooring", "marine.keeping"),
        ("PID", "control.pid"),
        ("FMU", "--target fmu2"),
        ("JONSWAP", "marine.waves"),
        ("Modelica", "coming-from-other-tools"),
        ("simulink", "FMU"),
        ("OrcaFlex", "risers"),
    ],
)
def test_what_users_look_for_is_answered(looked_for, found):
    result = bgc_doc(*looked_for.split())
    assert result.exit_code == 0 and found in " ".join(result.stdout.split())


def test_an_entry_of_another_group_names_the_topic():
    assert bgc_doc("PID").stdout.endswith("See also: Controller, control.pid, topics PID\n")
    assert bgc_doc("topics", "PID").stdout.startswith("PID  (topic)\n\n`Pid` and `SampledPid`")


# --- searching ------------------------------------------------------------------------------


def listed(text: str) -> list[str]:
    return list(search(text, all_groups())[0])


def group(**texts: tuple[str, str]) -> Group:
    """A group of some names with their summaries and texts."""
    summaries = {name: summary for name, (summary, _) in texts.items()}
    return Group("some", "some", lambda: summaries, Entry, texts=lambda: texts)


def test_a_name_counts_more_than_a_summary_and_that_more_than_a_text():
    some = group(
        Pipe=("a pipe", "A valve ends it."),
        Twice=("a pipe", "A valve and another valve."),
        R=("damper, friction, valve", ""),
        CheckValve=("a seat", ""),
        Revalved=("a seat", "not a word of its own"),
    )
    names, closely = search("valve", [some])
    assert list(names) == ["CheckValve", "R", "Twice", "Pipe"] and closely
    assert names["R"] == "damper, friction, valve"
    assert search("another valve", [some]) == ({"Twice": "a pipe"}, False)
    assert len(search("a", [group(**{f"n{k}": ("a", "") for k in range(40)})])[0]) == 30


def test_a_word_with_digits_does_not_begin_a_longer_one():
    some = group(rodas5p=("a method", ""), ur5=("an arm", ""))
    assert search("rodas5", [some]) == ({}, False)
    assert list(search("ur5", [some])[0]) == ["ur5"]
    assert list(search("rodas", [some])[0]) == ["rodas5p"]


def test_all_words_are_looked_for_in_parts_chapters_and_diagnostics():
    assert "marine.waves.Jonswap" in listed("wave height")
    kinds = {find(name, all_groups())[0].kind for name in listed("datagram")}
    assert {"section", "diagnostic"} <= kinds
    assert listed("wave qqqqq") == []


def test_a_name_that_is_near_goes_before_a_text_that_mentions_the_word():
    """The page of BG040 has `Baem` as its example."""
    assert listed("Baem") == ["BG040"]
    assert "did you mean `beam`" in bgc_doc("Baem").stderr
    assert "did you mean `Kalman`" in bgc_doc("Kalmann").stderr


@pytest.mark.parametrize("text", ["", "   ", "(", "\\", "[a-z", "\x1b[31m", "x" * 10_000, "%s %d"])
def test_absurd_words_find_nothing(text):
    result = bgc_doc(text)
    assert result.exit_code == 1 and "error[BG040]" in result.stderr
    assert "\x1b" not in result.stderr
