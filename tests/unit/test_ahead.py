"""The runtime is compiled while a model is still being read."""

from pathlib import Path
from threading import Event
from time import sleep

import pytest

from bgc.building import ahead
from bgc.building.ahead import RuntimeAhead
from bgc.building.build import runtime_units, shared_runtime_units
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.options import Options

TEXT = (
    "model A { x : C(1); r : R(1); n : J0; n -> x, r; }\nscene s of A { observe x.q; run 1 s; }\n"
)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("BGC_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path


def model(folder, text=TEXT) -> Path:
    path = folder / "model.bg"
    path.write_text(text, encoding="utf-8")
    return path


def objects(folder):
    return list((folder / "cache" / "objects").glob("*.o"))


def test_the_runtime_is_in_the_cache_when_it_is_ready(folder):
    with RuntimeAhead() as started:
        started.ready()
        assert len(objects(folder)) == len(shared_runtime_units())
    stages = compile_scene(model(folder), Options())
    assert stages.built.library.is_file()
    assert len(objects(folder)) == len(runtime_units(frozenset())) + len(stages.emitted.units)


def test_a_model_with_a_mistake_ends_the_compilers(folder, monkeypatch):
    begun, ended = Event(), Event()

    def compile_forever(_, __, compilations):
        begun.set()
        while not compilations.ended:
            sleep(0.01)
        ended.set()

    monkeypatch.setattr(ahead, "compile_runtime", compile_forever)
    with pytest.raises(BgError) as error:
        compile_scene(
            model(folder, TEXT.replace("C(1)", "C(k)")), Options(), watch=lambda _: begun.wait(10)
        )
    assert [d.code for d in error.value.diagnostics] == ["BG211"]
    assert ended.is_set()
    assert not objects(folder)


def test_a_mistake_of_the_model_comes_before_a_missing_compiler(folder, monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(BgError) as error:
        compile_scene(model(folder, TEXT.replace("C(1)", "C(k)")), Options())
    assert [d.code for d in error.value.diagnostics] == ["BG211"]
    with pytest.raises(BgError) as error:
        compile_scene(model(folder), Options())
    assert [d.code for d in error.value.diagnostics] == ["BG051"]


def test_a_runtime_that_could_not_be_compiled_ahead_is_compiled_with_the_model(folder, monkeypatch):
    def fail(*_):
        raise OSError("the disk was full")

    monkeypatch.setattr(ahead, "compile_runtime", fail)
    assert compile_scene(model(folder), Options()).built.library.is_file()


def test_earlier_stages_start_no_compiler(folder, monkeypatch):
    monkeypatch.setattr(ahead, "find_toolchain", lambda: pytest.fail("a compiler was looked for"))
    assert compile_scene(model(folder), Options(), until="emit").emitted.units
    assert not (folder / "cache" / "objects").exists()
