# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The server of the live page: header, frames, and refused requests."""

import asyncio
import json
from types import SimpleNamespace

import pytest
from aiohttp import WSMsgType, WSServerHandshakeError
from aiohttp.test_utils import TestClient, TestServer
from view_messages import filled_model
from vsa_tools.view.server import Server


def served(model):
    def source(namespace):
        if namespace != "/vsa":
            raise LookupError(f"no joint {namespace}")
        return SimpleNamespace(model=model, to_json=lambda: model.to_json(10.1))

    return Server(SimpleNamespace(namespace="/vsa", joints=lambda: ["/vsa"], source=source))


async def connect(server, path="/ws", headers=None, messages=2):
    async with TestClient(TestServer(server.application)) as client:
        page = await client.get("/")
        async with client.ws_connect(path, headers=headers or {}) as socket:
            received = [await socket.receive() for _ in range(messages)]
        missing = await client.get("/view.py")
        return (
            await page.text(),
            [json.loads(one.data) for one in received if one.type is WSMsgType.TEXT],
            missing.status,
        )


def test_a_new_page_receives_the_channels_and_then_all_stored_bins():
    model = filled_model()
    page, (header, frame), missing = asyncio.run(connect(served(model)))
    assert "view.js" in page
    assert header["namespace"] == "/vsa"
    assert header["channels"] == model.series.channels
    assert len(frame["low"]) == len(header["channels"])
    assert frame["end"] - frame["begin"] == len(frame["low"][0])
    assert frame["state"]["transmission_1"]["status"] == "VALID"
    assert frame["state"]["joints"] == ["/vsa"]
    assert missing == 404


def test_a_page_of_another_origin_is_refused():
    with pytest.raises(WSServerHandshakeError, match="403"):
        asyncio.run(connect(served(filled_model()), headers={"Origin": "http://elsewhere.example"}))


def test_an_unknown_joint_is_refused():
    with pytest.raises(WSServerHandshakeError, match="404"):
        asyncio.run(connect(served(filled_model()), path="/ws?joint=/left"))
