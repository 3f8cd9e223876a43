# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Threads of the linear algebra libraries that numpy and scipy have loaded."""

import ctypes
from pathlib import Path

_LIBRARIES = ("blas", "blis", "mkl_rt", "libgomp", "libomp", "libiomp")  # parts of file names
# Functions `void f(int threads)`, of OpenBLAS in wheels (with and without 64-bit indices), OpenBLAS, BLIS, MKL, OpenMP.
_SETTERS = (
    "scipy_openblas_set_num_threads64_", "scipy_openblas_set_num_threads",
    "openblas_set_num_threads64_", "openblas_set_num_threads",
    "bli_thread_set_num_threads", "MKL_Set_Num_Threads", "omp_set_num_threads",
)  # fmt: skip


def limit_blas_threads() -> None:
    """Run linear algebra in the calling thread: worker threads on busy cores delay a sample by 100 ms.

    Applies to the libraries loaded so far: call it after the imports.
    """
    for path in loaded_libraries():
        library = ctypes.CDLL(path)
        for name in _SETTERS:
            if hasattr(library, name):
                getattr(library, name)(ctypes.c_int(1))
                break


def loaded_libraries() -> list[str]:
    """Files of the linear algebra libraries in this process."""
    mapped = {line.split(maxsplit=5)[5] for line in Path("/proc/self/maps").read_text().splitlines() if "/" in line}
    return sorted(path for path in mapped if ".so" in path and any(part in Path(path).name for part in _LIBRARIES))
