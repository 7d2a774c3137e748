"""The server of a command, beside what the command does or until a signal ends it."""

import asyncio
import os
import sys
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from threading import Event, Thread
from typing import TYPE_CHECKING

import click

from bgc.diagnostics.catalogue.machine import package_missing
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.cli.signals import outlive_clients

if TYPE_CHECKING:  # needs aiohttp, which is optional
    from bgc.runtime.view.server import Server

_PERIOD = 0.5  # s between two looks for a signal where the system does not interrupt a wait


@contextmanager
def serving(server: "Server", port: int) -> Iterator[Thread]:
    """Serve pages in a thread as long as the block runs, which begins when clients may come.

    What the server raises is raised here. Signals that end a command are raised in the block.
    Within an event loop they would be raised at any place, also in a destructor, where Python
    ignores exceptions: the command would go on.
    """
    is_ready = Event()
    running: list[tuple[asyncio.AbstractEventLoop, asyncio.Task[None]]] = []
    failed: list[BaseException] = []

    async def cancellable() -> None:
        task = asyncio.ensure_future(server.serve(port, is_ready.set))
        running.append((asyncio.get_running_loop(), task))
        with suppress(asyncio.CancelledError):
            await task

    def run() -> None:
        try:
            asyncio.run(cancellable())
        except BaseException as problem:
            failed.append(problem)
        finally:
            is_ready.set()

    thread = Thread(target=run, daemon=True, name="bgc page")
    thread.start()
    try:
        is_ready.wait()
        if not failed:
            yield thread
        if failed:
            raise failed[0]
    finally:
        for loop, task in running:
            with suppress(RuntimeError):  # it has ended
                loop.call_soon_threadsafe(task.cancel)
        thread.join()


def wait_for(thread: Thread) -> None:
    """Wait until a server ends, or a signal ends the command."""
    while thread.is_alive():
        thread.join(_PERIOD)


def prepare_serving(what: str) -> None:
    """Prepare to serve pages for `what`; BG058 where the package that does so is missing."""
    try:
        import aiohttp  # noqa: F401  (optional, and slow to load)
    except ImportError as problem:
        raise BgError([package_missing("aiohttp", what, "view")]) from problem
    outlive_clients()


def announce(server: "Server", no_browser: bool) -> None:
    """Print the address of a server, and open it unless `no_browser`."""
    click.echo(f"{server.url}\nCtrl-C ends it")
    if not no_browser and not _open_browser(server.url):
        click.echo("no browser was found: open the address in one of this machine", err=True)


def _open_browser(url: str) -> bool:
    """Open the page in the user's browser; False where there is none with windows."""
    if sys.platform.startswith("linux"):
        windows = any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"))
        if not windows:  # text browsers would take the terminal
            return False
    try:
        return webbrowser.open(url)
    except webbrowser.Error:
        return False
