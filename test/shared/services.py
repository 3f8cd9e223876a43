# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Calls of services with repetition: a single response can be lost."""

import time

TIMEOUT = 3.0  # [s] without a response after which a request is repeated
MAX_REQUESTS = 10


def answer_of(node, until, kind, service, request):
    """Response of a service; `until(condition)` spins the node.

    A response is lost if discovery has not matched its reader yet, or if the server was killed and is still listed.
    """
    client = node.create_client(kind, service)
    until(client.service_is_ready)
    futures = []
    for _ in range(MAX_REQUESTS):
        futures.append(client.call_async(request))
        deadline = time.monotonic() + TIMEOUT
        until(lambda end=deadline: any(future.done() for future in futures) or time.monotonic() > end)
        if answers := [future.result() for future in futures if future.done()]:
            node.destroy_client(client)
            return answers[0]
    raise AssertionError(f"{service} does not respond")
