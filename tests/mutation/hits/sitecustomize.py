"""Mark which blocks of bgc run, in this process and in those that it starts.

Python loads this module at start-up where its folder is on PYTHONPATH. BGC_HITS names a file with
a byte for each block, BGC_BLOCKS the table of `blocks.py`.
"""

import json
import mmap
import os
import sys
from importlib.machinery import SourceFileLoader
from pathlib import Path

sys.path.insert(1, str(Path(__file__).parents[1]))
from blocks import marked

_FIRST = json.loads(Path(os.environ["BGC_BLOCKS"]).read_text(encoding="utf-8"))
with open(os.environ["BGC_HITS"], "r+b") as _file:  # noqa: PTH123
    hits = mmap.mmap(_file.fileno(), 0)
_plain = SourceFileLoader.source_to_code


def _source_to_code(self, data, path, *, _optimize=-1):  # type: ignore[no-untyped-def]
    name = str(path).rpartition("/bgc/")[2]
    if name in _FIRST:
        data = marked(bytes(data).decode(), _FIRST[name])
    return _plain(self, data, path, _optimize=_optimize)


SourceFileLoader.source_to_code = _source_to_code  # type: ignore[method-assign,assignment]
