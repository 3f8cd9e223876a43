# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
import pytest
from vsa_driver.acquisition.calibration import Calibration, Tare, TareError, take_tares
from vsa_driver.tuning import TARE_SAMPLES

MS = 1_000_000
START_NS = 1_800_000_000_000_000_000


def add_all(tare, forces, start_ns=START_NS):
    """Add a force for each millisecond; the tared forces."""
    return [tare.add(start_ns + i * MS, force) for i, force in enumerate(forces)]


def tare_of(max_std=0.1, max_gap_ms=100):
    return Tare(max_std, max_gap_ms * MS)


def test_scale_sign_and_offset_make_an_affine_map():
    assert Calibration.of(2.0, -1.0, reverse=False)(3.0) == 5.0
    assert Calibration.of(2.0, -1.0, reverse=True)(3.0) == -7.0


def test_the_inverse_gives_the_value_of_the_signal():
    line = Calibration.of(1e-5, 0.003, reverse=True)
    assert line.inverse(line(1234)) == pytest.approx(1234, abs=1e-9)


def test_tare_makes_the_mean_of_the_last_forces_zero():
    tare = tare_of()
    wave = [3.0 + (-1) ** i * 0.05 for i in range(TARE_SAMPLES)]
    assert add_all(tare, [100.0] * 1000 + wave)[:1000] == [100.0] * 1000
    assert take_tares([tare])[0] == pytest.approx(3.0)
    later_ns = START_NS + (1000 + TARE_SAMPLES) * MS
    assert tare.add(later_ns, 3.5) == pytest.approx(0.5)
    add_all(tare, [4.0] * TARE_SAMPLES, later_ns + MS)  # a second tare is of the sensor's force, not of the tared one
    assert take_tares([tare])[0] == pytest.approx(4.0)


def test_tare_is_refused_while_the_force_varies_or_samples_are_missing():
    tare = tare_of()
    with pytest.raises(TareError, match=f"0 of {TARE_SAMPLES}"):
        take_tares([tare])[0]
    add_all(tare, [0.01 * i for i in range(TARE_SAMPLES)])
    with pytest.raises(TareError, match="not stationary"):
        take_tares([tare])[0]
    assert tare.offset == 0.0


@pytest.mark.parametrize("gap_ms", [101, 60_000, -1])
def test_tare_restarts_after_a_gap_of_the_stamps_and_keeps_its_offset(gap_ms):
    tare = tare_of(max_gap_ms=100)
    add_all(tare, [3.0] * TARE_SAMPLES)
    take_tares([tare])[0]
    after_ns = START_NS + (TARE_SAMPLES - 1 + gap_ms) * MS
    assert tare.add(after_ns, 5.0) == pytest.approx(2.0)
    with pytest.raises(TareError, match=f"1 of {TARE_SAMPLES}"):
        take_tares([tare])[0]
    add_all(tare, [5.0] * (TARE_SAMPLES - 1), after_ns + MS)
    assert take_tares([tare])[0] == pytest.approx(5.0)


def test_a_gap_within_the_limit_does_not_restart_the_tare():
    tare = tare_of(max_gap_ms=100)
    add_all(tare, [3.0] * (TARE_SAMPLES // 2))
    add_all(tare, [3.0] * (TARE_SAMPLES // 2), START_NS + (TARE_SAMPLES // 2 - 1 + 100) * MS)
    assert take_tares([tare])[0] == pytest.approx(3.0)
