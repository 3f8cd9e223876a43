"""The one door to numba: one source, compiled where numba is there, plain Python and numpy where it is not."""

import os
from collections.abc import Callable
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
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
        before = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = before or _cache_folder(_package(Path(function.__code__.co_filename).resolve().parent))
        try:
            accelerated: Function = numba.njit(cache=True, error_model="numpy")(function)
        finally:
            numba.config.CACHE_DIR = before
        return accelerated


def _package(folder: Path) -> Path:
    """The outermost package that a folder of sources belongs to."""
    while (folder.parent / "__init__.py").exists():
        folder = folder.parent
    return folder


@lru_cache
def _cache_folder(sources: Path) -> str:
    # numba looks at the caller's own file only: machine code must not outlive a change anywhere in its package
    digest = sha256(b"".join(path.read_bytes() for path in sorted(sources.rglob("*.py")))).hexdigest()[:16]
    base = sources / "__pycache__" if os.access(sources, os.W_OK) else Path.home() / ".cache" / "vsa"
    return str(base / f"numba-{digest}")
