"""The one door to numba: what is written once runs compiled where numba is there, and as plain numpy where it is not."""

import os
from collections.abc import Callable
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

try:
    if os.environ.get("VSA_NO_NUMBA"):
        raise ImportError("numba is switched off by VSA_NO_NUMBA")
    import numba
except ImportError:
    ACCELERATED = False

    def compiled(function: Function) -> Function:
        """`function` unchanged: numba is absent."""
        return function

else:
    ACCELERATED = True

    def compiled(function: Function) -> Function:
        """`function` compiled at its first call; the machine code is kept on disk for the next process."""
        accelerated: Function = numba.njit(cache=True, error_model="numpy")(function)
        return accelerated
