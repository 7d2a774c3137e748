"""Take the pictures of the library's scenes: `python .site/scenes.py [SCENE ..]`.

Each is the first scene of a file of `library/scenes` after two thirds of its run, as the page of
`bgc view --export` draws it. They stand beside the files. Needs Chromium and Playwright.
"""

from __future__ import annotations

import base64
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING

from needs import browser, stop_if_missing

if TYPE_CHECKING:
    from playwright.sync_api import Page

SCENES = Path(__file__).resolve().parents[1] / "library" / "scenes"
SIZE = {"width": 720, "height": 450}
PART = 2 / 3
ARGUMENTS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
DRAWN = """(() => {
  const { stage, store } = bgcView;
  if (!stage) return null;
  stage.draw();
  return stage.canvas.toDataURL("image/jpeg", 0.8);
})()"""


def picture(page: Page, replay: Path) -> bytes | None:
    """A JPEG of the scene of a replay; None where nothing is drawn in space."""
    page.goto(replay.as_uri())
    _until(page, "window.bgcView && bgcView.frames > 2")
    page.evaluate("bgcView.setTheme('light'); document.body.classList.add('hidden-side')")
    page.evaluate(f"bgcView.seek({PART} * bgcView.store.last)")
    _until(page, f"Math.abs(bgcView.shownTime() - {PART} * bgcView.store.last) < 1e-6")
    frames = page.evaluate("bgcView.frames")
    _until(page, f"bgcView.frames > {frames} + 3")
    drawn = page.evaluate(DRAWN)
    return base64.b64decode(drawn.partition(",")[2]) if drawn else None


def _until(page: Page, script: str, seconds: float = 120.0) -> None:
    end = time.monotonic() + seconds
    while not page.evaluate(script):
        if time.monotonic() > end:
            raise TimeoutError(script)
        time.sleep(0.05)


def main(names: list[str]) -> None:
    """Write the pictures of the named files, or of all."""
    stop_if_missing(("playwright", "pip install playwright"), programs=("bgc",))
    chromium = browser()
    # An optional package, which was looked for above.
    from playwright.sync_api import sync_playwright

    files = [SCENES / f"{name}.bg" for name in names] or sorted(SCENES.glob("*.bg"))
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as driver:
        opened = driver.chromium.launch(executable_path=chromium, args=ARGUMENTS)
        page = opened.new_page(viewport=SIZE)
        for file in files:
            replay = Path(folder) / f"{file.stem}.html"
            subprocess.run(("bgc", "view", file, "--export", replay, "--quiet"), check=True)
            drawn = picture(page, replay)
            if drawn:
                file.with_suffix(".jpg").write_bytes(drawn)
                print(f"{file.stem}: {len(drawn):,} bytes", flush=True)
        opened.close()


if __name__ == "__main__":
    main(sys.argv[1:])
