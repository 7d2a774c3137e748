"""The server of a command: alone until a signal ends it, or beside what the command does."""

import asyncio
import os
import signal
import sys
import webbrowser
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager, suppress
from threading import Event, Thread
from types import FrameType
from typing import Any

import click

from bgc.diagnostics.catalogue.machine import package_missing
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.cli.signals import ENDING, outlive_clients

_Handler = Callable[[int, FrameType | None], object]


def run_until_signal(work: Coroutine[None, None, None]) -> None:
    """Run a coroutine in an event loop; a signal that ends the command cancels it.

    When the coroutine has cleaned up, the handler of `catch_signals` is called. Within the loop it
    would raise at any place, also in a destructor, where Python ignores exceptions: the command
    would go on.
    """
    received: list[tuple[_Handler, int]] = []

    async def cancelled_by_signals() -> None:
        loop, task = asyncio.get_running_loop(), asyncio.ensure_future(work)
        handlers = {}
        for number in ENDING:
            handler = signal.getsignal(number)
            if not callable(handler):
                continue  # ignored, or without a handler of this process

            def receive(number: int = number, handler: _Handler = handler) -> None:
                received.append((handler, number))
                task.cancel()

            try:
                loop.add_signal_handler(number, receive)
            except NotImplementedError:  # Windows: the handler goes on to raise
                continue
            handlers[number] = handler
        try:
            await asyncio.wait([task])
        finally:
            for number, handler in handlers.items():
                loop.remove_signal_handler(number)
                signal.signal(number, handler)
        if not received:
            task.result()

    asyncio.run(cancelled_by_signals())
    for handler, number in received[:1]:
        handler(number, None)


@contextmanager
def serving_beside(
    serve: Callable[[Callable[[], None]], Coroutine[None, None, None]],
) -> Iterator[None]:
    """Serve in a thread as long as the block runs, which begins when clients may come.

    `serve` is called with a function to be called then. What it raises before is raised here.
    """
    is_ready = Event()
    running: list[tuple[asyncio.AbstractEventLoop, asyncio.Task[None]]] = []
    failed: list[BaseException] = []

    async def cancellable() -> None:
        task = asyncio.ensure_future(serve(is_ready.set))
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
    is_ready.wait()
    try:
        if failed:
            raise failed[0]
        yield
    finally:
        for loop, task in running:
            with suppress(RuntimeError):  # it has ended
                loop.call_soon_threadsafe(task.cancel)
        thread.join()


def prepare_serving(what: str) -> None:
    """Prepare to serve pages for `what`; BG058 where the package that does so is missing."""
    try:
        import aiohttp  # noqa: F401  (optional, and slow to load)
    except ImportError as problem:
        raise BgError([package_missing("aiohttp", what, "view")]) from problem
    outlive_clients()


def announcing(server: Any, no_browser: bool) -> Callable[[], None]:
    """Make a function that prints the address of a server and opens it, unless `no_browser`."""

    def announce() -> None:
        click.echo(f"{server.url}\nCtrl-C ends it")
        if not no_browser and not _open_browser(server.url):
            click.echo("no browser was found: open the address in one of this machine", err=True)

    return announce


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
