# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parallel tasks in forked processes: results, progress and failures."""

import os

import pytest
from vsa_common.fork import ForkedTasks, forked_map


def test_results_are_in_the_order_of_the_tasks_and_every_step_is_reported():
    steps = []

    def task(name, count):
        def run(report):
            for _ in range(count):
                report(2.0)
            return name, os.getpid()

        return run

    results = ForkedTasks(task("slow", 50), task("fast", 3)).results(steps.append)
    assert [name for name, _ in results] == ["slow", "fast"]
    assert len({os.getpid(), *(process for _, process in results)}) == 3
    assert sum(steps) == 106.0


def test_the_exception_of_a_failed_task_is_raised(tmp_path):
    missing = tmp_path / "missing" / "file"
    with pytest.raises(OSError, match="missing/file"):
        ForkedTasks(lambda report: missing.touch(), lambda report: None).results()


def test_a_process_that_ends_without_a_result_is_an_error():
    with pytest.raises(OSError, match="without a result"):
        ForkedTasks(lambda report: os._exit(3)).results()


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_a_map_has_its_results_in_the_order_of_the_items(workers):
    steps = []
    assert forked_map(lambda item: item * item, range(4), workers, steps.append) == [0, 1, 4, 9]
    assert sum(steps) == 4
    assert forked_map(lambda item: item, [], workers, steps.append) == []
