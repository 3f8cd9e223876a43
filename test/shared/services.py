"""Calls of services that do not hang on one lost answer."""

import time

UNHEARD = 3.0  # s without an answer after which a service is asked again ...
ASKED = 10  # ... so many times


def answer_of(node, until, kind, service, request):
    """Answer of a service, while `until(condition)` lets the node work.

    It is asked again where none comes: one is lost whose reader was not found yet, or whose server had been killed
    and was still listed.
    """
    client = node.create_client(kind, service)
    until(client.service_is_ready)
    asked = []
    for _ in range(ASKED):
        asked.append(client.call_async(request))
        patience = time.monotonic() + UNHEARD
        until(lambda end=patience: any(future.done() for future in asked) or time.monotonic() > end)
        if answers := [future.result() for future in asked if future.done()]:
            node.destroy_client(client)
            return answers[0]
    raise AssertionError(f"{service} does not answer")
