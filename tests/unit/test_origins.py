"""A value outside its range is refused by the name of the parameter that the user set."""

import pytest
from model_files import model_file

import bgc

FILE = model_file("origins")


@pytest.fixture(scope="module")
def swing():
    return bgc.compile(FILE, scene="swing")


def refused(model, **parameters):
    with pytest.raises(bgc.BgError) as error:
        model.simulate(parameters={name.replace("_", "."): v for name, v in parameters.items()})
    (diagnostic,) = error.value.diagnostics
    assert diagnostic.code == "BG061" and "`mid.part.m`" in diagnostic.message
    return diagnostic


def test_the_outer_parameter_that_the_run_sets_is_named_with_both_places(swing):
    diagnostic = refused(swing, total=50.0)
    assert diagnostic.message.startswith("25 kg is outside")
    assert "`total`" in diagnostic.note and "change `total`" in diagnostic.help
    assert "other" not in diagnostic.note + diagnostic.help
    assert diagnostic.span.text == "total"
    assert [label.span.text for label in diagnostic.labels] == ["m"]


def test_one_between_that_the_run_sets_itself_is_named_in_its_place(swing):
    diagnostic = refused(swing, mid_half=30.0)
    assert "`mid.half`" in diagnostic.note and diagnostic.span.text == "half"


def test_the_parameter_itself_needs_no_other_name(swing):
    diagnostic = refused(swing, mid_part_m=30.0)
    assert not diagnostic.note and not diagnostic.labels


def test_values_of_a_scene_name_all_that_they_follow_from_also_from_the_cache():
    for _ in range(2):  # compiled, then from the cache
        assert "`total` and `other`" in refused(bgc.compile(FILE, scene="heavy")).note
