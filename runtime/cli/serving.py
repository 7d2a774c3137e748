"""A server of a command, which a signal ends."""

from __future__ import annotations

import asyncio
import signal
from collections.abc import Callable, Coroutine
from types import FrameType

from bgc.runtime.cli.signals import ENDING

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
        for name in ENDING:
            number = getattr(signal, name, None)
            handler = None if number is None else signal.getsignal(number)
            if number is None or not callable(handler):
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
