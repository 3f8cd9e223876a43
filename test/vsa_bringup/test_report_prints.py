"""What is drawn beside the page is there when the block ends, and its failure is not lost."""

import pytest
from vsa_bringup.report_prints import beside


def test_all_works_are_done_when_the_block_ends(tmp_path):
    with beside(lambda: (tmp_path / "one").touch(), lambda: (tmp_path / "two").touch()):
        (tmp_path / "three").touch()
    assert {path.name for path in tmp_path.iterdir()} == {"one", "two", "three"}


def test_the_reason_of_a_failed_work_arrives(tmp_path):
    missing = tmp_path / "missing" / "file"
    with pytest.raises(OSError, match="missing/file"), beside(lambda: missing.touch(), lambda: None):
        pass


def test_a_work_that_dies_is_noticed():
    with pytest.raises(OSError, match="without a word"), beside(lambda: __import__("os")._exit(3)):
        pass
