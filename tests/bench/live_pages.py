"""Pages of `bgc build --target html`: `python live_pages.py [SCENE ..] [--seconds S]`.

Of scenes of the library: the size of the page, raw and compressed by gzip; the seconds of processor
time of zig for its module, and of all other stages; in Chromium, from the file without a network,
simulated seconds for each second of the clock, and the memory of the module; and the largest
difference from the shared object over the first S seconds (10), over the range of its column.
Columns whose range is below 1e-9 of their largest absolute value are compared with that value.

All default scenes take some five minutes. An earlier module in the cache shows as no time of zig.
"""

from __future__ import annotations

import argparse
import gzip
import os
import shutil
import tempfile
from pathlib import Path

import numpy as np
from playwright.sync_api import Browser, sync_playwright

from bgc.options import Options
from bgc.resolution.library import library_folder
from bgc.runtime.running.model_loading import load_model
from bgc.runtime.running.run import with_capped_step
from bgc.runtime.running.simulate import method_of, times_of
from bgc.runtime.web.page_export import live_page

SCENES = ("two_beam_crane", "knuckle_boom_hydraulic", "knuckle_boom_at_sea", "offshore_lift")
FLAGS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
FOLDERS = ("scenes", "examples")


def find_scene(name: str) -> tuple[Path, str]:
    """The file of the library that declares a scene `NAME`, or `FILE:NAME`."""
    stem, _, scene = name.rpartition(":")
    for folder in FOLDERS:
        for path in sorted((library_folder() / folder).glob(f"{stem or '*'}.bg")):
            if f"scene {scene} " in path.read_text("utf-8"):
                return path, scene
    raise SystemExit(f"no file of the library has a scene {name}")


def measure(browser: Browser, name: str, seconds: float) -> str:
    """One line of the table."""
    file, scene = find_scene(name)
    before = os.times()
    page = live_page(file, Options(scene))
    after = os.times()
    zig = (
        after.children_user + after.children_system - before.children_user - before.children_system
    )
    own = after.user + after.system - before.user - before.system
    times = np.linspace(0.0, seconds, round(50 * seconds) + 1)
    with tempfile.TemporaryDirectory() as folder:
        path = page.save(Path(folder) / "page.html")
        context = browser.new_context(offline=True)
        shown = context.new_page()
        shown.goto(f"{path.as_uri()}?quality=low")
        done = shown.evaluate("(times) => bgcView.source.simulate(times)", times.tolist())
        context.close()
    rows = np.array(done["rows"])
    size, packed = len(page.document.encode()), len(gzip.compress(page.document.encode(), 9))
    return (
        f"{name:28} {size / 1e6:6.2f} {packed / 1e6:6.2f} {zig:6.1f} {own:6.1f} "
        f"{seconds / done['seconds']:7.1f} {done['bytes'] / 1e6:6.1f} "
        f"{difference(file, scene, times, rows):9.1e}"
    )


def difference(file: Path, scene: str, times: np.ndarray, rows: np.ndarray) -> float:
    """The largest difference of the rows from the shared object's, over the columns' ranges."""
    model = load_model(file, Options(scene, shapes=True))
    method, _ = method_of(model)
    if model.facts.duration:
        method = with_capped_step(method, times_of(model, method), model.facts.timed)
    native = np.full((len(times), model.row_width), np.nan)
    with model.started(method, bool(model.accounts)) as instance:
        status, count = instance.run(times, native)
    assert count == len(times), status
    span, largest = np.ptp(native, axis=0), np.abs(native).max(axis=0)
    scale = np.where(span > 1e-9 * largest, span, np.maximum(largest, 1.0))
    if model.accounts:  # the residual is rounding of the other accounts
        scale[-1] = scale[-4:-1].max()
    return float((np.abs(rows - native).max(axis=0) / scale).max())


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--seconds", type=float, default=10.0)
    given = parser.parse_args()
    print(f"{'scene':28}     MB  gzip  zig s  own s  x real  MB mem  difference")
    with sync_playwright() as driver:
        chromium = driver.chromium.launch(
            executable_path=shutil.which("chromium"), args=list(FLAGS)
        )
        for name in given.scenes:
            print(measure(chromium, name, given.seconds), flush=True)
        chromium.close()


if __name__ == "__main__":
    main()
