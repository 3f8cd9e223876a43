# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Conversion of stamps between nanoseconds and messages."""

from types import SimpleNamespace

import pytest
from vsa_common.stamps import nanoseconds, set_stamp


@pytest.mark.parametrize("stamp_ns", [0, 1, 999_999_999, 1_000_000_000, 1_700_000_000_123_456_789])
def test_a_round_trip_preserves_the_stamp(stamp_ns):
    stamp = SimpleNamespace(sec=0, nanosec=0)
    set_stamp(stamp, stamp_ns)
    assert nanoseconds(stamp) == stamp_ns
    assert 0 <= stamp.nanosec < 1_000_000_000
