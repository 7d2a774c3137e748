"""`bgc --version`."""

from __future__ import annotations

import json
import platform
from importlib import metadata

from bgc.runtime.running.structures import ABI


def version_text(as_json: bool) -> str:
    """Return `bgc, version 1.2.3`, or JSON for programs.

    The JSON object has `version`, that of the package; `abi`, the interface between compiled models
    and the runtime; `python` and `platform`.
    """
    version = metadata.version("bgc-lang")
    if not as_json:
        return f"bgc, version {version}"
    facts = {
        "version": version,
        "abi": ABI,
        "python": platform.python_version(),
        "platform": f"{platform.system().lower()}-{platform.machine().lower()}",
    }
    return json.dumps(facts)
