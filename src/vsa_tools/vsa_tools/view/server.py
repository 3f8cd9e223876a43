# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""HTTP and WebSocket server of the live page; the only module that imports aiohttp."""

import asyncio
import json
import sys
from collections.abc import Callable
from importlib.resources import files
from typing import Any, Protocol
from urllib.parse import urlsplit

from aiohttp import ClientSession, WSMsgType, web
from vsa_tools.view.time_series import BIN_NS, TimeSeriesStore
from vsa_tools.view.view_model import ViewModel

FRAME_RATE_HZ = 10.0  # of each page: smooth for the eye at low load
STATE_EVERY = 3  # frames per update of table and status: text is readable at about 3 Hz
_TYPES = {".js": "text/javascript", ".css": "text/css", ".html": "text/html", ".txt": "text/plain"}
_POLICY = "default-src 'self'; style-src 'self' 'unsafe-inline'; connect-src 'self' ws: wss:; img-src 'self' data:"


class Source(Protocol):
    """The data of one joint."""

    @property
    def model(self) -> ViewModel:
        """The view model; the server reads its time series."""

    def to_json(self) -> dict[str, Any]:
        """The current state."""


class Joints(Protocol):
    """The joints of this ROS domain."""

    namespace: str  # of the default joint

    def joints(self) -> list[str]:
        """Their namespaces."""

    def source(self, namespace: str) -> Source:
        """The joint at `namespace`. Raises LookupError for an unknown one."""


class Server:
    """The page, its files, and a WebSocket that sends the frames of one joint to each page."""

    def __init__(self, joints: Joints) -> None:
        self._joints = joints
        self.application = web.Application()
        self.application.add_routes([web.get("/ws", self._serve_socket), web.get("/{name:[A-Za-z.]*}", _file)])

    async def _serve_socket(self, request: web.Request) -> web.WebSocketResponse:
        origin = request.headers.get("Origin")
        if origin and urlsplit(origin).netloc != request.host:
            raise web.HTTPForbidden(text="pages of other origins are refused")
        namespace = request.query.get("joint", self._joints.namespace)
        try:
            source = self._joints.source(namespace)
        except LookupError as error:
            raise web.HTTPNotFound(text=f"{error}\n") from error
        socket = web.WebSocketResponse(heartbeat=5.0, compress=False)
        await socket.prepare(request)
        sender = asyncio.ensure_future(self._send(socket, namespace, source))
        try:
            async for message in socket:
                if message.type is WSMsgType.ERROR:
                    break
        finally:
            sender.cancel()
        return socket

    async def _send(self, socket: web.WebSocketResponse, namespace: str, source: Source) -> None:
        """Send the header, then the new bins of each frame, until the page closes."""
        series: TimeSeriesStore = source.model.series
        try:
            header = {"namespace": namespace, "channels": series.channels, "bin_s": 1e-9 * BIN_NS}
            await socket.send_str(json.dumps(header))
            begin, epoch, count = 0, series.epoch, 0
            while not socket.closed:
                frame: dict[str, Any] = {}
                if series.epoch != epoch:
                    begin, epoch = 0, series.epoch
                if series.end > begin:
                    frame = series.frame(begin)
                    begin = frame["end"]
                if count % STATE_EVERY == 0:
                    frame["state"] = source.to_json() | {"joints": self._joints.joints()}
                if frame:
                    await socket.send_str(json.dumps(frame, separators=(",", ":")))
                count += 1
                await asyncio.sleep(1.0 / FRAME_RATE_HZ)
        except (ConnectionError, RuntimeError):  # the page closed during a send
            pass


async def _file(request: web.Request) -> web.Response:
    name = request.match_info["name"] or "index.html"
    path = files("vsa_tools.view") / "static" / name
    kind = _TYPES.get("." + name.rsplit(".", 1)[-1])
    if kind is None or not path.is_file():
        raise web.HTTPNotFound(text=f"no {name} here\n")
    headers = {"Content-Security-Policy": _POLICY, "Cache-Control": "no-cache"}
    return web.Response(body=path.read_bytes(), content_type=kind, charset="utf-8", headers=headers)


async def serve(server: Server, host: str, port: int, work: Callable[[], Any], period: float) -> None:
    """Serve until cancelled; call `work` every `period` [s]. Raises OSError where the port is in use."""
    runner = web.AppRunner(server.application, access_log=None)
    await runner.setup()
    try:
        await web.TCPSite(runner, host, port, shutdown_timeout=1.0).start()
        while True:
            work()
            await asyncio.sleep(period)
    finally:
        await runner.cleanup()


async def receive(address: str) -> None:
    """Receive and discard all frames of a page at `address` (http://...): the load of a page on another computer."""
    async with ClientSession() as session, session.ws_connect(f"{address}/ws") as socket:
        async for _ in socket:
            pass


if __name__ == "__main__":
    asyncio.run(receive(sys.argv[1]))
