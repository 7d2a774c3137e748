"""The script of the page of `bgc view` in a frame: `python page_frames.py [SCENE ..]`.

For scenes of the library, an arm of 24 joints and a tree of 31 bodies, while they run in pace with
the clock: draw calls and triangles of a frame with shadows, milliseconds of script in a frame
(median and 99 %), kilobytes that arrive in a second, and the frames of a second. A frame at 60 Hz
has 16.7 ms. Without a graphics card Chromium draws on the processor: the times are therefore taken
in a small window without shadows, and frames and the 99 % are those of the machine. The counts and
the median are those of the page.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from growing import text_of
from live_pages import FLAGS, find_scene
from playwright.sync_api import Browser, Page, sync_playwright

SCENES = (
    "two_beam_crane", "knuckle_boom_hydraulic", "knuckle_boom_at_sea", "offshore_lift", "gantry",
    "ur5", "excavator", "arm:24", "tree:31",
)  # fmt: skip
WINDOW = {"width": 480, "height": 300}
BGC = (sys.executable, "-c", "from bgc.runtime.cli import main; main()")
SECONDS = 4.0

_DRAWN = """(({ parts, renderer }) =>
  [parts.length, renderer.info.render.calls, renderer.info.render.triangles])(bgcView.stage)"""
_COUNT = """(() => {
  const view = bgcView, times = [], loop = view.loop;
  view.loop = function (now) {
    const before = performance.now();
    loop.call(view, now);
    times.push(performance.now() - before);
  };
  window.counted = { times, bytes: 0, begun: performance.now() };
  view.source.socket.addEventListener("message", ({ data }) => {
    counted.bytes += data.byteLength ?? data.length;
  });
})()"""
_READ = """(() => {
  const { times, bytes, begun } = counted;
  const sorted = [...times].sort((a, b) => a - b);
  const at = (q) => sorted[Math.floor(q * (sorted.length - 1))];
  const seconds = (performance.now() - begun) / 1000;
  return [at(0.5), at(0.99), bytes / 1000 / seconds, times.length / seconds];
})()"""


def drawn(name: str, folder: Path) -> tuple[Path, str]:
    """The file and the scene of a name; a mechanism gets a shape for each of its links."""
    if ":" not in name:
        return find_scene(name)
    text = text_of(name)
    links = re.findall(r"(\w+) -> mount(\d+) ->", text)
    shapes = "".join(
        f"  shape capsule(4 cm) from {'mount0' if parent == 'ground' else parent} to node{k};\n"
        for parent, k in links[1:]
    )
    scene = text.index("\nscene ")
    end = text.rindex("}", 0, scene)
    path = folder / f"{name.replace(':', '_')}.bg"
    path.write_text(text[:end] + shapes + text[end:], "utf-8")
    return path, re.findall(r"\nscene (\w+)", text)[0]


def open_page(page: Page, url: str) -> None:
    """Open an address and wait for its first frames."""
    page.goto(url)
    while not page.evaluate("window.bgcView && bgcView.frames > 3"):
        time.sleep(0.1)


def measure(browser: Browser, name: str, folder: Path) -> str:
    """One line of the table."""
    file, scene = drawn(name, folder)
    command = [*BGC, "view", "--no-browser", str(file), "--scene", scene]
    served = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert served.stdout is not None
    context = browser.new_context(viewport=WINDOW)
    try:
        page = context.new_page()
        url = served.stdout.readline().strip()
        open_page(page, f"{url}&quality=high")
        shapes, calls, triangles = page.evaluate(_DRAWN)
        open_page(page, f"{url}&quality=low")
        page.evaluate("bgcView.source.send('play')")
        page.wait_for_timeout(1000)
        page.evaluate(_COUNT)
        page.wait_for_timeout(1000 * SECONDS)
        usual, late, rate, frames = page.evaluate(_READ)
    finally:
        context.close()
        served.terminate()
        served.wait()
    counts = f"{name:24} {shapes:6} {calls:6} {triangles:9}"
    return f"{counts} {usual:7.2f} {late:7.2f} {rate:6.0f} {frames:9.1f}"


def main() -> None:
    """Print the table."""
    print(f"{'scene':24} shapes  calls triangles  ms 50%  ms 99%   kB/s  frames/s")
    with sync_playwright() as driver, tempfile.TemporaryDirectory() as folder:
        chromium = driver.chromium.launch(
            executable_path=shutil.which("chromium"), args=[*FLAGS, "--ignore-gpu-blocklist"]
        )
        for name in sys.argv[1:] or SCENES:
            print(measure(chromium, name, Path(folder)), flush=True)
        chromium.close()


if __name__ == "__main__":
    main()
