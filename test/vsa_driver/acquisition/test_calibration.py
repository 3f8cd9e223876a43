import pytest
from vsa_driver.acquisition.calibration import TARE_SAMPLES, Calibration, Tare, TareError


def test_scale_sign_and_offset_make_a_straight_line():
    assert Calibration.of(2.0, -1.0, reverse=False)(3.0) == 5.0
    assert Calibration.of(2.0, -1.0, reverse=True)(3.0) == -7.0


def test_the_inverse_gives_the_signal_back():
    line = Calibration.of(1e-5, 0.003, reverse=True)
    assert line.inverse(line(1234)) == pytest.approx(1234, abs=1e-9)


def test_tare_makes_the_mean_of_the_last_forces_zero():
    tare = Tare(spread=0.1)
    for _ in range(1000):
        assert tare.add(100.0) == 100.0
    for i in range(TARE_SAMPLES):
        tare.add(3.0 + (-1) ** i * 0.05)
    assert tare.take() == pytest.approx(3.0)
    assert tare.add(3.5) == pytest.approx(0.5)
    for _ in range(TARE_SAMPLES):  # a second tare starts from the sensor, not from the first
        tare.add(4.0)
    assert tare.take() == pytest.approx(4.0)


def test_tare_is_refused_while_the_force_moves_or_is_not_yet_known():
    tare = Tare(spread=0.1)
    with pytest.raises(TareError, match=f"0 of {TARE_SAMPLES}"):
        tare.take()
    for i in range(TARE_SAMPLES):
        tare.add(0.01 * i)
    with pytest.raises(TareError, match="moves"):
        tare.take()
    assert tare.offset == 0.0
