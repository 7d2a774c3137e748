"""The page: one HTML document that contains its script, and for a replay also its rows."""

from __future__ import annotations

import base64
import html
import json
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from bgc.diagnostics.catalogue.view import page_not_bundled
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.view.history import Rows

_BUNDLE: Final = Path(__file__).parent / "static" / "view.js"
_ICON: Final = (
    "data:image/svg+xml,%3Csvg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 32 32'%3E"
    "%3Crect width='32' height='32' rx='7' fill='%230b6bcb'/%3E%3Cpath d='M7 20h16m0 0-5-5m5 0v10' "
    "fill='none' stroke='white' stroke-width='3' stroke-linecap='round'/%3E%3C/svg%3E"
)
_MESH_TYPE: Final = "application/octet-stream"


def bundle() -> str:
    """The script of the page; BG007 where it was not bundled."""
    try:
        return _BUNDLE.read_text("utf-8")
    except OSError as problem:
        raise BgError([page_not_bundled()]) from problem


def page(
    title: str, script: str, data: str = "", nonce: str = "", kind: str = "replay", policy: str = ""
) -> str:
    """Compose the document: its style is in the script, and it requests nothing.

    `data` is the JSON of a run of this `kind`: `replay`, or `model` for one that the page computes.
    `policy` is the content security policy of a document without a server.
    """
    allowed = f' nonce="{nonce}"' if nonce else ""
    recorded = f'<script type="application/json" id="{kind}">{data}</script>' if data else ""
    rules = f'<meta http-equiv="Content-Security-Policy" content="{policy}">' if policy else ""
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8">{rules}'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<title>{html.escape(title)} - bgc</title><link rel="icon" href="{_ICON}"></head><body>'
        f"{recorded}<script{allowed}>{_inside_script(script)}</script></body></html>"
    )


def replay_data(description: dict[str, Any], rows: Rows, meshes: Sequence[Path] = ()) -> str:
    """The recorded run as JSON that may stand inside a script element.

    Rows are little-endian float32, column after column, which compresses better, deflated (zlib),
    in base64.
    """
    columns = rows.astype("<f4", copy=False).T.tobytes()
    content = {
        "description": description,
        "rows": len(rows),
        "data": base64.b64encode(zlib.compress(columns, 9)).decode(),
        "meshes": [data_url(path) for path in meshes],
    }
    return json.dumps(content, separators=(",", ":")).replace("<", "\\u003c")


def data_url(path: Path) -> str:
    """The address of a mesh that contains the file."""
    return f"data:{_MESH_TYPE};base64,{base64.b64encode(path.read_bytes()).decode()}"


def _inside_script(text: str) -> str:
    return text.replace("</script", "<\\/script").replace("<!--", "<\\!--")
