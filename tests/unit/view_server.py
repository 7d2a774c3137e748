"""A page server for tests, and requests to it."""

import asyncio

import aiohttp


async def serving(server, visit):
    """Serve while `visit` runs."""
    ready = asyncio.Event()
    task = asyncio.create_task(server.serve(0, ready.set))
    try:
        await asyncio.wait_for(ready.wait(), 10)
        async with aiohttp.ClientSession() as session:
            await asyncio.wait_for(visit(session), 20)
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


def address(server, path="/", token=None):
    return f"http://127.0.0.1:{server.port}{path}?token={token or server.token}"


def home(server):
    return {"Origin": f"http://127.0.0.1:{server.port}"}
