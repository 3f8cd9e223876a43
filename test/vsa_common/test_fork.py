"""What copies of this process do is all there at the end, and no failure is lost."""

import os

import pytest
from vsa_common.fork import ForkedTasks


def test_results_come_in_the_order_of_the_works_and_every_step_is_told():
    told = []

    def work(name, count):
        def run(tell):
            for _ in range(count):
                tell(2.0)
            return name, os.getpid()

        return run

    results = ForkedTasks(work("slow", 50), work("fast", 3)).results(told.append)
    assert [name for name, _ in results] == ["slow", "fast"]
    assert len({os.getpid(), *(process for _, process in results)}) == 3
    assert sum(told) == 106.0


def test_the_reason_of_a_failed_work_arrives(tmp_path):
    missing = tmp_path / "missing" / "file"
    with pytest.raises(OSError, match="missing/file"):
        ForkedTasks(lambda tell: missing.touch(), lambda tell: None).results()


def test_a_work_that_dies_is_noticed():
    with pytest.raises(OSError, match="without a word"):
        ForkedTasks(lambda tell: os._exit(3)).results()
