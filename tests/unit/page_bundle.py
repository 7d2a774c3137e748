"""The bundle of the page of `bgc view`, and the build backend that makes it."""

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.view.page import bundle

ROOT = Path(__file__).parents[2]


def backend() -> ModuleType:
    """The build backend, which is no part of the package."""
    spec = spec_from_file_location("bgc_build", ROOT / ".build" / "bgc_build.py")
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def ensure_page() -> None:
    """Bundle the page where the one under test is absent or was made from other sources."""
    built = backend()
    digest = built.source_digest()
    if not built.is_of_sources(_bundled(), digest):
        built.bundle_page()
    assert built.is_of_sources(_bundled(), digest), "the page is old: python .build/bgc_build.py"


def _bundled() -> str:
    try:
        return bundle()
    except BgError:  # BG007: there is none
        return ""
