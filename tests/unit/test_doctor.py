import tempfile
import threading
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import PackageNotFoundError, metadata, version
from pathlib import Path

import pytest

from bgc.building import toolchain
from bgc.runtime.cli import doctor
from bgc.runtime.cli.doctor import Finding, Health, examine, is_well, report


def named(findings: tuple[Finding, ...], name: str) -> Finding:
    return next(finding for finding in findings if finding.name == name)


@pytest.fixture(autouse=True)
def own_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("BGC_CACHE_DIR", str(tmp_path / "cache"))


def test_a_complete_machine_is_well():
    findings = examine()
    assert is_well(findings)
    assert named(findings, "C compiler").health is Health.GOOD
    assert str(named(findings, "cache").found).startswith("/")


def test_without_a_compiler_it_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(toolchain, "find_spec", lambda name: None)
    findings = examine()
    assert not is_well(findings)
    compiler = named(findings, "C compiler")
    assert compiler.health is Health.MISSING
    assert "pip install ziglang" in compiler.remedy
    assert named(findings, "Graphviz").health is Health.OPTIONAL


def test_a_compiler_that_fails_is_not_well(monkeypatch, tmp_path):
    script = tmp_path / "cc"
    script.write_text("#!/bin/sh\necho 'stdint.h: no such file'\nexit 1\n")
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    compiler = named(examine(), "C compiler")
    assert compiler.health is Health.MISSING
    assert "stdint.h" in compiler.found


def test_an_unwritable_cache_is_no_illness(monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setenv("BGC_CACHE_DIR", str(tmp_path / "file" / "cache"))
    findings = examine()
    assert named(findings, "cache").health is Health.OPTIONAL
    assert is_well(findings)


def test_missing_packages_are_named(monkeypatch):
    monkeypatch.setattr(doctor, "find_spec", lambda name: None if name == "lark" else name)
    packages = named(examine(), "Python packages")
    assert (packages.health, packages.remedy) == (Health.MISSING, "pip install lark")


def test_each_extra_has_its_packages_or_the_way_to_them(monkeypatch):
    """A new extra of the distribution needs a line that says what it is for."""
    extras = metadata("bgc-lang").get_all("Provides-Extra")
    assert {*doctor._EXTRAS} == {*extras} - {"dev", "site", "test"}
    assert named(examine(), "pandas").found == f"pandas {version('pandas')}"

    def missing(name: str) -> str:
        raise PackageNotFoundError(name)

    monkeypatch.setattr(doctor, "version", missing)
    found = named(examine(), "lsp")
    assert (found.health, found.found) == (Health.OPTIONAL, "not installed")
    assert found.remedy == 'pip install "bgc-lang[lsp]", for `bgc lsp`'


def test_the_report_puts_remedies_below_what_they_are_for():
    findings = (Finding("a", Health.GOOD, "here"), Finding("bcd", Health.MISSING, "no", "get it"))
    assert report(findings).splitlines() == ["ok  a    here", "!!  bcd  no", "         -> get it"]


def test_a_cache_that_another_command_works_in_is_examined(tmp_path):
    """Folders come and go while the files are counted."""
    cache, over = tmp_path / "cache", threading.Event()
    (cache / "kept").mkdir(parents=True)
    (cache / "kept" / "file").write_bytes(bytes(3_000_000))

    def work() -> None:
        while not over.is_set():
            with tempfile.TemporaryDirectory(dir=cache) as folder:
                Path(folder, "a").write_text("a")

    with ThreadPoolExecutor(1) as pool:
        pool.submit(work)
        try:
            found = [str(named((doctor._cache(),), "cache").found) for _ in range(300)]
        finally:
            over.set()
    assert all(text.endswith("(3.0 MB)") for text in found)
