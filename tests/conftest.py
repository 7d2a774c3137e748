"""Options of the whole test suite, and the check of every intermediate result in it."""

import os

import pytest

os.environ["BGC_VERIFY"] = "1"  # commands in processes of their own inherit it


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--bless", action="store_true", help="rewrite the golden files")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what compares with blessed files, so that `-m golden --bless` rewrites all of them."""
    for item in items:
        if "bless" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.golden)


@pytest.fixture
def bless(request: pytest.FixtureRequest) -> bool:
    return bool(request.config.getoption("--bless"))
