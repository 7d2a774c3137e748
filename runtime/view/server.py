"""The server of the page: on the loopback interface, behind a token."""

from __future__ import annotations

import asyncio
import secrets
import socket
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from time import time
from typing import Any, Final

from aiohttp import WSCloseCode, WSMsgType, web

from bgc.diagnostics.catalogue.view import cannot_listen
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.view.history import TIMES, History, Rows
from bgc.runtime.view.page import bundle, page
from bgc.runtime.view.protocol import (
    ALL_ROWS,
    LONGEST,
    NEW_ROWS,
    POWERS,
    finite,
    pack,
    pack_rows,
    read_command,
)
from bgc.runtime.view.scene_description import Description
from bgc.runtime.view.steered import Steered

HOST: Final = "127.0.0.1"
_BEHIND: Final = 65536  # bytes waiting for a client, above which it misses rows
_MOST_MESSAGES: Final = 8  # likewise
_CLOSING: Final = 0.2  # s


class Client:
    """A connected page, and the messages that wait for it in order."""

    def __init__(self, socket: web.WebSocketResponse, transport: asyncio.Transport | None) -> None:
        self.socket = socket
        self._transport = transport
        self.watches = False
        self._messages: asyncio.Queue[str | bytes] = asyncio.Queue()

    @property
    def is_behind(self) -> bool:
        """Return whether it does not read as fast as messages come."""
        waiting = self._transport.get_write_buffer_size() if self._transport is not None else 0
        return waiting > _BEHIND or self._messages.qsize() > _MOST_MESSAGES

    def send(self, message: str | bytes) -> None:
        """Queue a message."""
        self._messages.put_nowait(message)

    async def write(self) -> None:
        """Send what is queued until the client has gone."""
        with suppress(ConnectionError, RuntimeError):
            while True:
                message = await self._messages.get()
                if isinstance(message, str):
                    await self.socket.send_str(message)
                else:
                    await self.socket.send_bytes(message)
                self._messages.task_done()

    async def flush(self) -> None:
        """Wait until all that is queued has been sent."""
        await self._messages.join()


class Server:
    """The page of one live or recorded run, for any number of clients.

    Attributes
    ----------
    token
        The secret that every request has to name.
    port
        The port, known once `listen` has returned.
    """

    def __init__(
        self, description: Description, meshes: list[Path], rows: Rows | None = None
    ) -> None:
        """Serve a recorded run with its `rows`, or a live one, whose player `attach` gives."""
        self.token = secrets.token_urlsafe(18)
        self.port = 0
        self._description = description
        self._model = 0  # number of exchanges
        self._meshes = meshes
        self._script = bundle()
        self._recorded = rows
        self._player: Steered[Any] | None = None
        self._history = History(TIMES + description["width"])
        self._values: list[float] = []
        self._fault: dict[str, Any] | None = None
        self._epoch = 0
        self._clients: set[Client] = set()
        self._holders: dict[str, Client] = {}  # of devices: the page that steered each last
        self._loop: asyncio.AbstractEventLoop | None = None

    @property
    def url(self) -> str:
        """The address of the page, with its token."""
        return f"http://{HOST}:{self.port}/?token={self.token}"

    def attach(self, player: Steered[Any]) -> None:
        """Let clients steer a player or a loop."""
        self._player = player

    def publish(self, kind: str, content: Any) -> None:
        """Take an event of the player, in its thread."""
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._on_event, kind, content)

    async def serve(self, port: int, ready: Callable[[], None]) -> None:
        """Serve until the task is cancelled; `ready` is called when clients may come.

        Raises BgError BG008 where the port is not available.
        """
        self._loop = asyncio.get_running_loop()
        listener = _listen(port)
        self.port = listener.getsockname()[1]
        application = web.Application(client_max_size=LONGEST)
        application.router.add_get("/", self._page)
        application.router.add_get("/ws", self._websocket)
        application.router.add_get("/mesh/{number}", self._mesh)
        application.on_shutdown.append(self._say_goodbye)
        runner = web.AppRunner(application, access_log=None, shutdown_timeout=_CLOSING)
        await runner.setup()
        try:
            await web.SockSite(runner, listener).start()
            ready()
            await asyncio.Event().wait()
        finally:
            await runner.cleanup()

    # --- requests -------------------------------------------------------------------------

    def _allow(self, request: web.Request) -> None:
        """Refuse a request without the token, from a foreign page, or for another host."""
        given = request.query.get("token", "")
        here = {f"{HOST}:{self.port}", f"localhost:{self.port}"}
        origin = request.headers.get("Origin")
        foreign = origin is not None and origin not in {f"http://{host}" for host in here}
        right = secrets.compare_digest(given.encode(), self.token.encode())
        if not right or foreign or request.headers.get("Host") not in here:
            raise web.HTTPForbidden(text="403: the address of this page needs its token\n")

    async def _page(self, request: web.Request) -> web.Response:
        self._allow(request)
        nonce = secrets.token_urlsafe(12)
        policy = (
            f"default-src 'none'; script-src 'nonce-{nonce}'; style-src 'unsafe-inline'; "
            f"img-src data: blob:; connect-src 'self' data: blob: ws://{HOST}:{self.port} "
            f"ws://localhost:{self.port}; base-uri 'none'; form-action 'none'; "
            "frame-ancestors 'none'"
        )
        return web.Response(
            text=page(self._description["scene"], self._script, nonce=nonce),
            content_type="text/html",
            headers={
                "Content-Security-Policy": policy,
                "Cache-Control": "no-store",
                "Referrer-Policy": "no-referrer",
                "X-Content-Type-Options": "nosniff",
            },
        )

    async def _mesh(self, request: web.Request) -> web.FileResponse:
        self._allow(request)
        number = request.match_info["number"]
        if not number.isdecimal() or int(number) >= len(self._meshes):
            raise web.HTTPNotFound
        return web.FileResponse(self._meshes[int(number)], headers={"Cache-Control": "no-store"})

    async def _websocket(self, request: web.Request) -> web.WebSocketResponse:
        if request.headers.get("Origin") is None:
            raise web.HTTPForbidden(text="403: a page has an origin\n")
        self._allow(request)
        socket = web.WebSocketResponse(compress=False, max_msg_size=LONGEST, heartbeat=20)
        await socket.prepare(request)
        client = Client(socket, request.transport)
        writer = asyncio.create_task(client.write())
        self._greet(client)
        self._clients.add(client)
        try:
            async for message in socket:
                if message.type is not WSMsgType.TEXT:
                    continue
                command = read_command(message.data)
                if command is None or self._player is None:
                    continue
                if command["type"] == "watch":
                    self._watch(client, command["value"])
                    continue
                if command["type"] == "hand":
                    self._holders[command["device"]] = client
                self._player.command(command)
        finally:
            self._clients.discard(client)
            self._watch(client, False)
            self._let_go(client)
            writer.cancel()
        return socket

    def _let_go(self, client: Client) -> None:
        """Centre the devices that a page held when it went: nobody is there to do so."""
        for device in [name for name, holder in self._holders.items() if holder is client]:
            del self._holders[device]
            if self._player is not None:
                self._player.command({"type": "let_go", "device": device})

    def _watch(self, client: Client, wanted: bool) -> None:
        """Read the meters of the bonds as long as a client watches them."""
        if client.watches != wanted and self._player is not None:
            client.watches = wanted
            watched = any(other.watches for other in self._clients)
            self._player.command({"type": "watch", "value": watched})

    def _greet(self, client: Client) -> None:
        """Send a new client the scene, and all that has happened."""
        client.send(self._scene())
        rows = self._history.rows if self._recorded is None else self._recorded
        client.send(pack_rows(ALL_ROWS, self._epoch, rows, time()))
        if self._player is not None:
            client.send(pack("state", self._player.state))
            if self._values:
                client.send(pack("values", {"values": finite(self._values)}))
            if self._fault is not None:
                client.send(pack("fault", self._fault))

    async def _say_goodbye(self, application: web.Application) -> None:
        clients = list(self._clients)
        with suppress(TimeoutError):  # the reason of an end is among the last messages
            await asyncio.wait_for(asyncio.gather(*(c.flush() for c in clients)), _CLOSING)
        for client in clients:
            await client.socket.close(code=WSCloseCode.GOING_AWAY)

    # --- events of the player -------------------------------------------------------------

    def _on_event(self, kind: str, content: Any) -> None:
        if kind == "rows":
            epoch, rows = content
            if epoch != self._epoch:
                self._epoch = epoch
                self._history.clear()
                self._fault = None
            self._history.append(rows)
            self._send(pack_rows(NEW_ROWS, epoch, rows, time()), may_miss=True)
            return
        if kind == "powers":
            epoch, row = content
            message = pack_rows(POWERS, epoch, row, time())
            for client in self._clients:
                if client.watches and not client.is_behind:
                    client.send(message)
            return
        if kind == "scene":
            self._exchange(*content)
            return
        if kind == "values":
            self._values = content
            content = {"values": finite(content)}
        elif kind == "fault" and content["stopped"]:
            self._fault = content
        elif kind == "state" and content["playing"]:
            self._fault = None
        self._send(pack(kind, content), may_miss=False)

    def _exchange(self, description: Description, meshes: list[Path]) -> None:
        """Serve another model, whose rows follow; the pages load themselves again."""
        self._description, self._meshes = description, meshes
        self._model += 1
        self._history = History(TIMES + description["width"])
        self._fault, self._values = None, []
        for client in self._clients:
            client.send(self._scene())

    def _scene(self) -> str:
        live = self._player is not None
        content = {"description": self._description, "model": self._model, "live": live}
        return pack("scene", content)

    def _send(self, message: str | bytes, may_miss: bool) -> None:
        """Send to all clients; one that is behind misses rows."""
        for client in self._clients:
            if not (may_miss and client.is_behind):
                client.send(message)


def _listen(port: int) -> socket.socket:
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        if hasattr(socket, "SO_REUSEADDR"):
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((HOST, port))
        listener.listen()
    except OSError as problem:
        listener.close()
        raise BgError([cannot_listen(port, problem.strerror or str(problem))]) from problem
    listener.setblocking(False)
    return listener
