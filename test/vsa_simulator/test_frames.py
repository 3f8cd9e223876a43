# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Frames of the simulated rig by its DBC file."""

import pytest
from vsa_driver.can.frames import RIG_DBC, FrameSet
from vsa_simulator.frames import RigFrames

FRAMES = FrameSet(RIG_DBC)


@pytest.mark.parametrize("side", [1, 2])
@pytest.mark.parametrize(("force", "sent"), [(12.5, 12.5), (900.0, 838.8607), (-1e6, -838.8608)])
def test_a_force_beyond_the_range_of_its_signal_is_sent_as_the_limit(side, force, sent):
    frame = RigFrames(FRAMES).transmission(side - 1, 7, force, 1234)
    decoded = FRAMES.message(f"Transmission{side}").decode(bytes(frame.data))
    assert decoded["Force"] == pytest.approx(sent, abs=1e-6)
    assert (decoded["EncoderCount"], decoded["RollingCounter"]) == (1234, 7)
