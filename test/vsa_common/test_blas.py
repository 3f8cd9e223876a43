# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Threads of linear algebra, in processes of their own, counted by threadpoolctl."""

import subprocess
import sys

IMPORTS = "import os; import numpy, scipy.linalg, threadpoolctl; from vsa_common.blas import *; "
COUNT = "print(*[library['num_threads'] for library in threadpoolctl.threadpool_info()]); "


def output_of(code):
    command = [sys.executable, "-c", IMPORTS + code]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split("\n")


def test_every_library_runs_in_the_calling_thread():
    names = "print(*[library['filepath'] for library in threadpoolctl.threadpool_info()]); "
    before, files, after, loaded, _ = output_of(
        f"threadpoolctl.threadpool_limits(2); {COUNT}{names}limit_blas_threads(); {COUNT}print(*loaded_libraries())"
    )
    assert {*before.split()} == {"2"}
    assert {*after.split()} == {"1"}
    assert {*files.split()} <= {*loaded.split()}


def test_a_product_of_matrices_starts_no_thread():
    count = "print(len(os.listdir('/proc/self/task'))); "
    before, after, _ = output_of(f"limit_blas_threads(); {count}a = numpy.ones((500, 500)); a @ a; {count}")
    assert after == before
