"""A plugin of pytest that writes which blocks of bgc each file of tests runs.

    BGC_HITS=.. BGC_BLOCKS=.. PYTHONPATH=SITE:tests/mutation/hits:tests/mutation \
        python -m pytest -p reach FILES

REACH names the file that it adds to: a line for each file of tests, with its time and what fails.
"""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from typing import Any

from sitecustomize import hits

_STORE = Path(os.environ["REACH"])


class Reach:
    def __init__(self) -> None:
        self.file, self.begun, self.failed = "", time.process_time(), list[str]()

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        file = nodeid.split("::")[0]
        if file != self.file:
            self.finish()
            self.file, self.begun, self.failed = file, sum(os.times()[:4]), []
            hits[:] = bytes(len(hits))

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed:
            self.failed.append(report.nodeid)

    def pytest_sessionfinish(self) -> None:
        self.finish()

    def finish(self) -> None:
        if self.file:
            row = {
                "file": self.file, "seconds": round(sum(os.times()[:4]) - self.begun, 1),
                "failed": self.failed, "hits": [k for k, hit in enumerate(hits[:]) if hit],
            }  # fmt: skip
            with _STORE.open("a", encoding="utf-8") as out:
                out.write(json.dumps(row) + "\n")
            print(self.file, row["seconds"], *self.failed, flush=True)


def pytest_configure(config: Any) -> None:
    config.pluginmanager.register(Reach())
