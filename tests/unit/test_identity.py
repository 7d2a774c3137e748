"""The identity of results that are kept between runs."""

from __future__ import annotations

from pathlib import Path

import pytest
from model_files import model_text

import bgc
from bgc.elaboration.scenes.variants import Change
from bgc.runtime.activity.simplifications import open_variants, stored_variants
from bgc.runtime.running.identity import scene_identity

FOLLOWER = model_text("identity_follower")


@pytest.fixture
def path(tmp_path: Path) -> Path:
    move(tmp_path, 1)
    path = tmp_path / "follower.bg"
    path.write_text(FOLLOWER)
    return path


def move(folder: Path, reach: float) -> None:
    (folder / "hand.csv").write_text(f"time,x,y,z\n0,0,0,0\n1,{reach},0,0\n")


def test_a_scene_is_the_same_as_long_as_it_would_give_the_same(path: Path) -> None:
    known = scene_identity(bgc.compile(path))
    path.write_text(f"// a comment\n{FOLLOWER}")
    model = bgc.compile(path)
    assert scene_identity(model) == known
    assert scene_identity(model, {"k": 4.0}) != known
    model.parameters["k"] = 4
    assert scene_identity(model) == scene_identity(bgc.compile(path), {"k": 4.0})
    move(path.parent, 2)
    assert scene_identity(bgc.compile(path)) != known
    move(path.parent, 1)
    path.write_text(FOLLOWER.replace("run 1 s;", "run 1 s; solver rodas5p(settle = 1 Hz);"))
    assert scene_identity(bgc.compile(path)) != known


def test_variants_that_were_found_are_those_of_one_motion(path: Path) -> None:
    variants = ((Change("k", "0", is_use=False),),)
    open_variants(bgc.compile(path)).keep(variants)
    assert stored_variants(bgc.compile(path)) == variants
    move(path.parent, 3)
    assert stored_variants(bgc.compile(path)) is None
