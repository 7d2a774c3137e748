"""The page of `bgc view` in Debian's Chromium, driven by Playwright."""

from __future__ import annotations

import shutil
import time
from collections.abc import Iterator
from pathlib import Path

import axe_playwright_python
from page_bundle import ensure_page
from playwright import sync_api

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
ARGUMENTS = (
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
)
AXE = (Path(axe_playwright_python.__file__).parent / "axe.min.js").read_text("utf-8")


def launched() -> Iterator[sync_api.Browser]:
    """A browser for the tests of a module."""
    ensure_page()
    with sync_api.sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield chromium
        chromium.close()


class View:
    """A page, and what it has complained about or requested."""

    def __init__(self, browser, url, offline=False, has_touch=False):
        self.context = browser.new_context(
            viewport={"width": 900, "height": 500},
            offline=offline,
            has_touch=has_touch,
            accept_downloads=True,
        )
        self.page = self.context.new_page()
        self.wrong, self.requests = [], []
        self.page.on("pageerror", lambda e: self.wrong.append(str(e)))
        self.page.on("console", self._on_console)
        self.page.on("request", lambda r: self.requests.append(r.url))
        self.page.goto(url)
        self.until("window.bgcView && bgcView.frames > 1")

    def _on_console(self, message):
        if message.type == "error" or "THREE" in message.text:
            self.wrong.append(message.text)

    def ask(self, script):
        return self.page.evaluate(script)

    def until(self, script, seconds=40.0):
        # Polled: the policy of the page refuses Playwright's own waiting.
        end = time.monotonic() + seconds
        while not self._holds(script):
            assert time.monotonic() < end, (script, self.wrong)
            time.sleep(0.03)

    def _holds(self, script):
        try:
            return self.ask(script)
        except sync_api.Error as problem:
            if "navigation" in problem.message:
                return False  # the page loads itself again
            raise

    def colours(self):
        """The number of colours of the canvas, in steps of a 16th."""
        return self.ask(
            """(() => {
              const view = bgcView; view.stage.draw();
              const small = document.createElement("canvas");
              [small.width, small.height] = [64, 48];
              const pen = small.getContext("2d");
              pen.drawImage(view.stage.canvas, 0, 0, 64, 48);
              const seen = new Set(), data = pen.getImageData(0, 0, 64, 48).data;
              for (let k = 0; k < data.length; k += 4)
                seen.add([0, 1, 2].map((c) => data[k + c] >> 4).join());
              return seen.size;
            })()"""
        )

    def check_access(self):
        """Check the page with the rules of axe-core, WCAG 2.2 AA and good practice."""
        self.ask(f"{AXE}; 0")
        found = self.ask("axe.run(document, { resultTypes: ['violations'] })")["violations"]
        assert [(rule["id"], [node["target"] for node in rule["nodes"]]) for rule in found] == []

    def close(self, origin):
        self.context.close()
        assert self.wrong == []
        assert [
            url for url in self.requests if not url.startswith((*origin, "data:", "blob:"))
        ] == []
