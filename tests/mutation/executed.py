"""Lines that a test file executes: of C by gcov, of `compiler/equations` by a trace."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
from collections import defaultdict
from pathlib import Path
from types import FrameType
from typing import Any

Lines = dict[str, set[int]]


class Trace:
    """Lines of files below a folder that run while it is on."""

    def __init__(self, folder: str) -> None:
        self.folder = folder
        self.wanted: dict[str, bool] = {}
        self.lines: Lines = defaultdict(set)

    def start(self) -> None:
        threading.settrace(self._call)
        sys.settrace(self._call)

    def _call(self, frame: FrameType, event: str, argument: Any) -> Any:
        name = frame.f_code.co_filename
        wanted = self.wanted.get(name)
        if wanted is None:
            wanted = self.wanted[name] = name.startswith(self.folder)
        return self._line if wanted else None

    def _line(self, frame: FrameType, event: str, argument: Any) -> Any:
        if event == "line":
            self.lines[frame.f_code.co_filename].add(frame.f_lineno)
        return self._line


def read_gcov(folder: Path) -> tuple[Lines, Lines]:
    """The lines of each C file that ran, and all that can; the counters are removed."""
    ran: Lines = defaultdict(set)
    known: Lines = defaultdict(set)
    counters = sorted(folder.glob("*.gcda"))
    if counters:
        command = ["gcov", "--json-format", "--stdout", *(path.name for path in counters)]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
        for text in done.stdout.splitlines():
            for file in json.loads(text)["files"] if text.strip() else ():
                for line in file["lines"]:
                    known[file["file"]].add(line["line_number"])
                    if line["count"]:
                        ran[file["file"]].add(line["line_number"])
    for path in counters:
        path.unlink()
    return ran, known
