"""A stand-in for Haply's Inverse Service: its WebSocket and its messages, with faults.

As docs.haply.co/inverseSDK/service/realtime/websocket-protocol describes it: all devices on
connection, then one message of states for each message received; the last force is held.
"""

from __future__ import annotations

import base64
import hashlib
import json
import socket
import struct
import threading
from typing import Any

_GUID = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"  # RFC 6455


class InverseService:
    """Serves one client; `fault` names what goes wrong after the first answer.

    `force` is what the service holds, `messages` what it received, parsed.
    """

    def __init__(self, devices: tuple[str, ...] = ("04C3",), fault: str = "") -> None:
        self.devices, self.fault = devices, fault
        self.force, self.position = [0.0] * 3, [0.0, -0.12, 0.15]
        self.messages: list[dict[str, Any]] = []
        self.pongs: list[bytes] = []
        self.answers = 0
        self.closed = threading.Event()
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def stop(self) -> None:
        self._listener.close()
        self._thread.join(5.0)

    def _serve(self) -> None:
        try:
            self._client, _ = self._listener.accept()
        except OSError:
            return
        with self._client:
            try:
                if self._shake_hands():
                    self._send(self._inventory())
                    while self._receive():
                        pass
            except OSError:
                pass
        self.closed.set()

    def _shake_hands(self) -> bool:
        header = b""
        while b"\r\n\r\n" not in header:
            header += self._client.recv(1000)
        if self.fault == "no_websocket":
            self._client.sendall(b"HTTP/1.1 200 OK\r\nContent-Length: 0\r\n\r\n")
            return False
        lines = dict(line.split(b": ") for line in header.split(b"\r\n")[1:] if line)
        assert lines[b"Upgrade"] == b"websocket" and lines[b"Sec-WebSocket-Version"] == b"13"
        accept = base64.b64encode(hashlib.sha1(lines[b"Sec-WebSocket-Key"] + _GUID).digest())
        answer = b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\n"
        self._client.sendall(answer + b"Sec-WebSocket-Accept: " + accept + b"\r\n\r\n")
        return True

    def _inventory(self) -> dict[str, Any]:
        config = {"type": "inverse3", "port": "COM\\12", "basis": {"permutation": "XYZ"}, "n": [1]}
        states = self._states()["inverse3"]
        return {"session_id": 7, "inverse3": [{**device, "config": config} for device in states]}

    def _states(self) -> dict[str, Any]:
        axes = dict(zip("xyz", self.position, strict=True))
        state = {
            "angular_position": {"a0": 1.0, "a1": -2e-7},
            "cursor_velocity": {"x": 0.25, "y": -1e-3, "z": 0.0},
            "cursor_position": axes,
            "control_mode": 'a "quoted, } one',
        }
        return {"inverse3": [{"device_id": name, "state": state} for name in self.devices]}

    def _send(self, message: Any, opcode: int = 1) -> None:
        data = message if isinstance(message, bytes) else json.dumps(message).encode()
        head = bytes([0x80 | opcode])
        head += bytes([len(data)]) if len(data) < 126 else b"\x7e" + struct.pack(">H", len(data))
        frame = head + data
        if self.fault == "in_parts":  # of TCP
            for k in range(0, len(frame), 97):
                self._client.sendall(frame[k : k + 97])
        else:
            self._client.sendall(frame)

    def _receive(self) -> bool:
        head = self._exactly(2)
        length = head[1] & 127
        assert head[1] & 128  # a client masks
        if length == 126:
            (length,) = struct.unpack(">H", self._exactly(2))
        mask, data = self._exactly(4), self._exactly(length)
        data = bytes(byte ^ mask[k % 4] for k, byte in enumerate(data))
        if head[0] & 15 == 10:
            self.pongs.append(data)
            return True
        if head[0] & 15 != 1:
            return False
        message = json.loads(data)
        self.messages.append(message)
        (device,) = message["inverse3"]
        vector = device["commands"]["set_cursor_force"]["vector"]
        self.force = [vector[axis] for axis in "xyz"]
        self._answer()
        return True

    def _answer(self) -> None:
        self.answers += 1
        fault = self.fault if self.answers > 1 else ""
        if fault == "silent":
            return
        if fault == "unplugged":
            self.devices = ()
        elif fault == "closed":
            self._send(b"\x03\xe8", 8)
        elif fault == "torn":
            self._client.sendall(b"\x01\x05hello")
        elif fault == "not_json":
            self._send(b'{"inverse3":[{"device_id":"04C3","state":{"cursor_position":{"x":nan}}}]}')
        elif fault == "ping":
            self._send(b"alive", 9)
        elif fault == "flood":
            for _ in range(200):
                self._send(self._states())
        self._send(self._states())

    def _exactly(self, count: int) -> bytes:
        data = b""
        while len(data) < count:
            more = self._client.recv(count - len(data))
            if not more:
                raise OSError
            data += more
        return data
