# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""CSV tables: columns by name, missing samples, error texts."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from vsa_common.io.tables import TableError, read_columns, write_columns


def table(tmp_path, content):
    path = tmp_path / "log.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def error_text(path, names=("stamp", "force")):
    with pytest.raises(TableError) as error:
        read_columns(path, names)
    assert "\n" not in str(error.value)
    assert str(path) in str(error.value)
    return str(error.value)


def test_columns_are_found_by_name_in_any_order(tmp_path):
    path = table(tmp_path, "force,extra,stamp\n1.5,x,0\n-2e-3,y,0.001\n")
    columns = read_columns(path, ["stamp", "force"])
    assert list(columns) == ["stamp", "force"]
    np.testing.assert_array_equal(columns["stamp"], [0.0, 0.001])
    np.testing.assert_array_equal(columns["force"], [1.5, -0.002])


def test_optional_columns_are_read_if_they_exist(tmp_path):
    path = table(tmp_path, "stamp,force\n0,1\n")
    assert list(read_columns(path, ["stamp"], ["force", "reference"])) == ["stamp", "force"]


def test_an_empty_cell_a_short_row_and_the_text_nan_are_missing_samples(tmp_path):
    path = table(tmp_path, "stamp,force\n0,\n1,nan\n2\n3,4\n")
    force = read_columns(path, ["stamp", "force"])["force"]
    assert [math.isnan(value) for value in force] == [True, True, True, False]


def test_writing_and_reading_preserve_every_digit(tmp_path):
    written = {"stamp": np.array([1.7e9 + 1 / 3, 0.1]), "force": np.array([-1e-300, 195.00000000000003])}
    path = tmp_path / "out.csv"
    write_columns(path, written)
    for name, column in read_columns(path, list(written)).items():
        np.testing.assert_array_equal(column, written[name])


def test_flags_are_written_as_numbers(tmp_path):
    path = tmp_path / "out.csv"
    write_columns(path, {"valid": np.array([True, False])})
    assert path.read_text() == "valid\n1\n0\n"


def test_a_missing_column_is_named_with_the_columns_found(tmp_path):
    text = error_text(table(tmp_path, "time,force\n0,1\n"))
    assert all(word in text for word in ("line 1", "stamp", "time"))


def test_a_cell_that_is_no_number_is_named_with_its_line(tmp_path):
    text = error_text(table(tmp_path, "stamp,force\n0,1\n1,soft\n"))
    assert all(word in text for word in ("line 3", "'soft'", "force"))


def test_a_row_that_is_too_long_is_named_with_its_line(tmp_path):
    assert "line 3" in error_text(table(tmp_path, "stamp,force\n0,1\n1,2,3\n2,3\n"))


def test_an_empty_file_and_a_file_without_rows_are_rejected(tmp_path):
    assert "line 1" in error_text(table(tmp_path, ""))
    assert "line 2" in error_text(table(tmp_path, "stamp,force\n"))


def test_an_absent_file_and_a_binary_file_are_rejected(tmp_path):
    error_text(tmp_path / "absent.csv")
    assert "line 2" in error_text(table(tmp_path, b"stamp,force\n0,\xff\xfe\n"))


def test_a_table_that_cannot_be_written_names_the_file(tmp_path):
    with pytest.raises(TableError, match="absent"):
        write_columns(tmp_path / "absent" / "out.csv", {"stamp": np.zeros(1)})


@settings(max_examples=300, deadline=None)
@given(st.one_of(st.binary(max_size=80), st.text(alphabet='stamp,force\n\r"0.1e-x ', max_size=80).map(str.encode)))
def test_any_bytes_are_read_or_rejected_with_one_line(tmp_path_factory, content):
    path = tmp_path_factory.mktemp("fuzz") / "log.csv"
    path.write_bytes(content)
    try:
        columns = read_columns(path, ["stamp", "force"])
        text = ""
    except TableError as error:
        columns = {"stamp": np.zeros(1), "force": np.zeros(1)}
        text = str(error)
    assert "\n" not in text
    assert len(columns["stamp"]) == len(columns["force"]) > 0
