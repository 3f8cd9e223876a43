"""`view`: the live page of one joint, on this computer unless asked otherwise."""

import argparse
import asyncio
import contextlib
import os
import signal
import sys
from collections.abc import Sequence

import rclpy
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args
from vsa_tools.view.node import Ears
from vsa_tools.view.server import Server, serve

NICE = 10  # who looks on never holds up what is looked at
POLL = 0.08  # seconds between two looks at what has arrived: about a frame


def main(args: Sequence[str] | None = None) -> int:
    """Serve until Ctrl-C; 1 with one line on stderr where the port cannot be had."""
    given = list(sys.argv if args is None else ["view", *args])
    options = _parser().parse_args(remove_ros_args(given)[1:])
    os.nice(NICE)
    rclpy.init(args=given, signal_handler_options=SignalHandlerOptions.NO)
    ears = Ears(options.namespace)
    try:
        asyncio.run(_run(ears, options.host, options.port))
    except (OSError, OverflowError) as error:
        print(f"view: {options.host}:{options.port}: {' '.join(str(error).split())}", file=sys.stderr)
        return 1
    finally:
        ears.close()
        rclpy.try_shutdown()
    return 0


async def _run(ears: Ears, host: str, port: int) -> None:
    task = asyncio.ensure_future(serve(Server(ears), host, port, ears.poll, POLL))
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, task.cancel)
    await asyncio.sleep(0.2)  # a port that is taken shows by now
    if not task.done():
        shown = f"[{host}]" if ":" in host else host
        print(f"live page of {ears.space or '/'}: http://{shown}:{port}/  (Ctrl-C ends it)", flush=True)
    with contextlib.suppress(asyncio.CancelledError):
        await task


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="view", description=__doc__)
    parser.add_argument("--port", type=int, default=8080, help="TCP port of the page (default: 8080)")
    text = "address to listen on (default: 127.0.0.1, this computer alone; 0.0.0.0 lets everyone on the network look)"
    parser.add_argument("--host", default="127.0.0.1", help=text)
    parser.add_argument("--namespace", default="/vsa", help="the joint's namespace (default: /vsa)")
    return parser


if __name__ == "__main__":
    sys.exit(main())
