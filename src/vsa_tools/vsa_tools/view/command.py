# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""`view`: the live page of one joint; by default it listens on this computer only."""

import argparse
import asyncio
import contextlib
import os
import signal
import sys
from collections.abc import Sequence

import rclpy
from rclpy.exceptions import InvalidNamespaceException
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args
from vsa_tools.view.node import Subscribers
from vsa_tools.view.server import Server, serve

NICE = 10  # below the priority of the nodes
POLL_S = 0.08  # [s] between two polls of the subscriptions: less than a frame of the page


def main(args: Sequence[str] | None = None) -> int:
    """Serve until Ctrl-C; 1, with one line on stderr, where port or namespace cannot be used."""
    given = list(sys.argv if args is None else ["view", *args])
    options = _parser().parse_args(remove_ros_args(given)[1:])
    os.nice(NICE)
    rclpy.init(args=given, signal_handler_options=SignalHandlerOptions.NO)
    try:
        subscribers = Subscribers(options.namespace)
    except InvalidNamespaceException as error:
        print(f"view: --namespace {options.namespace}: {' '.join(str(error).split())}", file=sys.stderr)
        rclpy.try_shutdown()
        return 1
    try:
        asyncio.run(_run(subscribers, options.host, options.port))
    except (OSError, OverflowError) as error:
        print(f"view: {options.host}:{options.port}: {' '.join(str(error).split())}", file=sys.stderr)
        return 1
    finally:
        subscribers.close()
        rclpy.try_shutdown()
    return 0


async def _run(subscribers: Subscribers, host: str, port: int) -> None:
    task = asyncio.ensure_future(serve(Server(subscribers), host, port, subscribers.poll, POLL_S))
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, task.cancel)
    await asyncio.sleep(0.2)  # a port in use has raised its error by now
    if not task.done():
        address = f"[{host}]" if ":" in host else host
        print(f"live page of {subscribers.namespace or '/'}: http://{address}:{port}/  (Ctrl-C ends it)", flush=True)
    with contextlib.suppress(asyncio.CancelledError):
        await task


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="view", description=__doc__)
    parser.add_argument("--port", type=int, default=8080, help="TCP port of the page (default: 8080)")
    text = "address to listen on (default: 127.0.0.1, this computer only; 0.0.0.0: all of the network)"
    parser.add_argument("--host", default="127.0.0.1", help=text)
    parser.add_argument("--namespace", default="/vsa", help="the joint's namespace (default: /vsa)")
    return parser


if __name__ == "__main__":
    sys.exit(main())
