"""Serves the live page and its numbers: the one door to aiohttp."""

import asyncio
import json
import sys
from collections.abc import Callable
from importlib.resources import files
from typing import Any, Protocol
from urllib.parse import urlsplit

from aiohttp import ClientSession, WSMsgType, web
from vsa_tools.view.time_series import WIDTH_NS, Board
from vsa_tools.view.view_model import Show

FRAMES = 10.0  # a second, to each page
WORDS = 3  # every so many frames the table comes along
_TYPES = {".js": "text/javascript", ".css": "text/css", ".html": "text/html", ".txt": "text/plain"}
_POLICY = "default-src 'self'; style-src 'self' 'unsafe-inline'; connect-src 'self' ws: wss:; img-src 'self' data:"


class Source(Protocol):
    """What a page shows of one joint."""

    @property
    def show(self) -> Show:
        """The curves."""

    def words(self) -> dict[str, Any]:
        """The table, now."""


class Joints(Protocol):
    """All joints that a page can choose from."""

    space: str  # the one that a page shows first

    def joints(self) -> list[str]:
        """Their namespaces."""

    def ear(self, space: str) -> Source:
        """One of them. Raises LookupError for one that is not there."""


class Server:
    """A page, its files, and a WebSocket on which every page gets its own joint at its own pace."""

    def __init__(self, joints: Joints) -> None:
        self._joints = joints
        self.application = web.Application()
        self.application.add_routes([web.get("/ws", self._talk), web.get("/{name:[A-Za-z.]*}", _file)])

    async def _talk(self, request: web.Request) -> web.WebSocketResponse:
        origin = request.headers.get("Origin")
        if origin and urlsplit(origin).netloc != request.host:
            raise web.HTTPForbidden(text="pages of other sites may not look in")
        space = request.query.get("joint", self._joints.space)
        try:
            source = self._joints.ear(space)
        except LookupError as error:
            raise web.HTTPNotFound(text=f"{error}\n") from error
        socket = web.WebSocketResponse(heartbeat=5.0, compress=False)
        await socket.prepare(request)
        sender = asyncio.ensure_future(self._send(socket, space, source))
        try:
            async for message in socket:
                if message.type is WSMsgType.ERROR:
                    break
        finally:
            sender.cancel()
        return socket

    async def _send(self, socket: web.WebSocketResponse, space: str, source: Source) -> None:
        """Hello, then what is new since the last frame, until the page goes away."""
        board: Board = source.show.board
        try:
            hello = {"hello": space, "channels": board.channels, "width": 1e-9 * WIDTH_NS}
            await socket.send_str(json.dumps(hello))
            begin, era, count = 0, board.era, 0
            while not socket.closed:
                frame: dict[str, Any] = {}
                if board.era != era:
                    begin, era = 0, board.era
                if board.end > begin:
                    frame = board.frame(begin)
                    begin = frame["end"]
                if count % WORDS == 0:
                    frame["words"] = source.words() | {"joints": self._joints.joints()}
                if frame:
                    await socket.send_str(json.dumps(frame, separators=(",", ":")))
                count += 1
                await asyncio.sleep(1.0 / FRAMES)
        except (ConnectionError, RuntimeError):  # the page was closed while a frame was under way
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
    """Serve until cancelled, doing `work` every `period` [s]. Raises OSError where the port is taken."""
    runner = web.AppRunner(server.application, access_log=None)
    await runner.setup()
    try:
        await web.TCPSite(runner, host, port, shutdown_timeout=1.0).start()
        while True:
            work()
            await asyncio.sleep(period)
    finally:
        await runner.cleanup()


async def look(address: str) -> None:
    """Take all that a page at `address` (http://...) would get, and draw nothing: a page on another computer."""
    async with ClientSession() as session, session.ws_connect(f"{address}/ws") as socket:
        async for _ in socket:
            pass


if __name__ == "__main__":
    asyncio.run(look(sys.argv[1]))
