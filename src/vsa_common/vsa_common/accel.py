# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Compilation by numba where it is installed; the same functions in plain Python where it is not."""

import os
from collections.abc import Callable
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeVar, cast

Function = TypeVar("Function", bound=Callable[..., Any])

try:
    if os.environ.get("VSA_NO_NUMBA"):
        raise ImportError("numba is switched off by VSA_NO_NUMBA")
    import numba
except ImportError:
    ACCELERATED = False

    def compiled(function: Function) -> Function:
        """`function` itself: numba is absent."""
        return function

else:
    ACCELERATED = True

    def compiled(function: Function) -> Function:
        """`function`, compiled at its first call; the machine code is cached on disk, unless VSA_NO_CACHE is set."""
        if os.environ.get("VSA_NO_CACHE"):
            return cast(Function, numba.njit(error_model="numpy")(function))
        former = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = former or _cache_folder(_package(Path(function.__code__.co_filename).resolve().parent))
        try:
            accelerated: Function = numba.njit(cache=True, error_model="numpy")(function)
        finally:
            numba.config.CACHE_DIR = former
        return accelerated


def _package(folder: Path) -> Path:
    """The outermost package that a folder of sources belongs to."""
    while (folder.parent / "__init__.py").exists():
        folder = folder.parent
    return folder


@lru_cache
def _cache_folder(sources: Path) -> str:
    # numba's index depends on the function's own file; the hash makes the cache depend on every file of the package,
    # and on the modules beside this one, whose functions other packages compile
    files = sorted({*sources.rglob("*.py"), *Path(__file__).parent.resolve().glob("*.py")})
    digest = sha256(b"".join(path.read_bytes() for path in files)).hexdigest()[:16]
    base = sources / "__pycache__" if os.access(sources, os.W_OK) else Path.home() / ".cache" / "vsa"
    return str(base / f"numba-{digest}")
