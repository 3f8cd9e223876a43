"""The filter step against filterpy and against numerical derivatives."""

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter
from vsa_estimator.filter import ekf as step
from vsa_estimator.force_law.transmission import COULOMB_SPEED, SIZE, force, peak_speed

TRUTH = np.array([0.010, 1e-3, 1e-2, 8.0, 267.2, 4000.0, -1.089e8, 0.3755, 16.39, 0.3])
REFERENCE = 0.0105
STD = np.array([1e-5, 2e-4, 2e-2, 0.05, 5.0, 200.0, 2e7, 0.2, 0.5, 0.1])


def law(z):
    """Eq. (6) written once more, for complex arguments inside the damper's range."""
    x, v, a, s, k2, d1, d2, mass, offset, coulomb = z
    spring = np.exp(s + k2 * (x - REFERENCE)) / k2 + offset
    return spring + d1 * v + d2 * v**3 + coulomb * np.tanh(v / COULOMB_SPEED) + mass * a


def held_law(z):
    """Eq. (6) beyond v*, where the damper keeps its greatest force 2/3 d1 v*."""
    x, v, a, s, k2, d1, d2, mass, offset, coulomb = z
    spring = np.exp(s + k2 * (x - REFERENCE)) / k2 + offset
    greatest = 2.0 / 3.0 * d1 * np.sqrt(d1 / (-3.0 * d2))
    return spring + np.sign(v.real) * greatest + coulomb * np.tanh(v / COULOMB_SPEED) + mass * a


def complex_step_gradient(function, z):
    gradient = np.empty(SIZE)
    for i in range(SIZE):
        shifted = z.astype(complex)
        shifted[i] += 1j * 1e-20 * max(abs(z[i]), 1e-3)
        gradient[i] = function(shifted).imag / (1e-20 * max(abs(z[i]), 1e-3))
    return gradient


CASES = [
    (law, TRUTH),
    (law, TRUTH * np.array([1, -2, 5, 1, 1, 1, 1, 1, 1, 1])),
    (held_law, TRUTH + 3e-3 * np.eye(10)[1]),
]


@pytest.mark.parametrize(("function", "z"), CASES)
def test_the_jacobian_is_the_complex_step_derivative_of_the_force_law(function, z):
    gradient, hessian = np.empty(SIZE), np.empty((SIZE, SIZE))
    value = force(z, REFERENCE, COULOMB_SPEED, gradient, hessian)
    assert value == pytest.approx(function(z.astype(complex)).real, rel=1e-13)
    expected = complex_step_gradient(function, z)
    assert gradient * STD == pytest.approx(expected * STD, rel=1e-10, abs=1e-12)


@pytest.mark.parametrize(("function", "z"), CASES)
def test_the_hessian_is_the_derivative_of_the_jacobian_but_for_coulomb_friction(function, z):
    hessian = np.empty((SIZE, SIZE))
    smooth = z.copy()
    smooth[9] = 0.0  # the friction's own curvature is left out on purpose: the reversal noise stands for it
    force(smooth, REFERENCE, COULOMB_SPEED, np.empty(SIZE), hessian)
    expected = np.empty((SIZE, SIZE))
    for i in range(SIZE):
        h = 1e-4 * STD[i]
        high, low = smooth.copy(), smooth.copy()
        high[i] += h
        low[i] -= h
        expected[i] = (complex_step_gradient(function, high) - complex_step_gradient(function, low)) / (2.0 * h)
    scale = np.outer(STD, STD)
    keep = np.ones((SIZE, SIZE), bool)
    keep[9, :] = keep[:, 9] = False
    assert (hessian * scale)[keep] == pytest.approx((expected * scale)[keep], rel=1e-5, abs=1e-9)


@pytest.mark.parametrize("ahead", [0.0, 0.004, 0.1])
@pytest.mark.parametrize("shares", [(1.0, 1.0), (0.7, 0.6)], ids=["rough", "smooth"])
def test_the_report_is_the_predicted_impedance_with_its_covariance_by_complex_step(ahead, shares):
    rng, jerk_density, out = np.random.default_rng(3), 1e-3, np.empty(16)
    root = STD[:, None] * rng.normal(size=(SIZE, SIZE))
    z, p, pull = TRUTH.copy(), root @ root.T, 0.1 * STD * rng.normal(size=SIZE)
    doubts = np.array([9.0, 7.0, 3e6, 0.04, *shares])
    step.report(z, p, pull, REFERENCE, ahead, jerk_density, doubts, out)
    assert np.array_equal(z, TRUTH)

    step.predict(z, p, ahead, jerk_density)
    step.carry(pull, ahead)
    sigma = np.exp(z[3] + z[4] * (z[0] - REFERENCE))
    stiffness = complex_step_gradient(lambda z: z[3] + z[4] * (z[0] - REFERENCE), z)
    damping = complex_step_gradient(lambda z: z[5] + 3.0 * z[6] * z[1] ** 2, z)
    by = np.vstack([np.eye(SIZE)[:3], stiffness, damping, np.eye(SIZE)[7]])
    pulled = by[3:5] @ pull
    place, speed = shares
    by[3, 0] *= place
    by[4, 1] *= speed
    covariance = by @ p @ by.T
    covariance[3:5, 3:5] += np.outer(pulled, pulled)
    covariance[3, 3] += (1.0 - place**2) * z[4] ** 2 * jerk_density * ahead**5 / 20.0  # new jerk counts whole
    covariance[4, 4] += (1.0 - speed**2) * (6.0 * z[6] * z[1]) ** 2 * jerk_density * ahead**3 / 3.0
    covariance[3, 4] += (1.0 - place * speed) * z[4] * 6.0 * z[6] * z[1] * jerk_density * ahead**4 / 8.0
    covariance[3, 3] += (9.0 / sigma) ** 2
    covariance[4, 4] += (3.0 * z[1] ** 2 * 3e6) ** 2 + 7.0**2
    covariance[5, 5] = 0.04
    values = [*z[:3], sigma, z[5] + 3.0 * z[6] * z[1] ** 2, z[7]]
    assert out[0:12:2] == pytest.approx(np.array(values), rel=1e-12)
    assert out[1:12:2] == pytest.approx(np.diag(covariance), rel=1e-9)
    expected = [sigma * covariance[3, 4], sigma * covariance[3, 5], covariance[4, 5]]
    assert out[12:15] == pytest.approx(np.array(expected), rel=1e-9)
    assert out[15] == peak_speed(z[5], z[6])


def test_the_damper_is_strongest_where_its_slope_vanishes():
    speed = peak_speed(4000.0, -1.089e8)
    assert 4000.0 + 3.0 * -1.089e8 * speed**2 == pytest.approx(0.0, abs=1e-9)
    assert peak_speed(4000.0, 0.0) == 1.0


class Reference:
    """The same filter on filterpy's ExtendedKalmanFilter with dense matrices."""

    def __init__(self, z, p):
        self.force = ExtendedKalmanFilter(SIZE, 1)
        self.force.x, self.force.P = z.reshape(-1, 1).copy(), p.copy()
        self.stroke = 0.010

    def predict(self, dt, jerk_density):
        ekf = self.force
        ekf.F = np.eye(SIZE)
        ekf.F[0, 1] = ekf.F[1, 2] = dt
        ekf.F[0, 2] = dt * dt / 2.0
        ekf.Q = np.zeros((SIZE, SIZE))
        ekf.Q[:3, :3] = jerk_density * np.array(
            [[dt**5 / 20, dt**4 / 8, dt**3 / 6], [dt**4 / 8, dt**3 / 3, dt**2 / 2], [dt**3 / 6, dt**2 / 2, dt]]
        )
        ekf.predict()

    def update(self, measured, gradient, expected, noise, free, steepness, own=0.0):
        """Gate, filterpy's update, then Schmidt: where a gain is barred, Joseph's form once more with it at 0.

        `own` noise makes the gain smaller, the covariance does not know it.
        """
        ekf = self.force
        prior, covariance, row = ekf.x.copy(), ekf.P.copy(), gradient.reshape(1, -1)
        noise += own
        variance = (row @ covariance @ row.T).item() + noise
        nis = (measured - expected) ** 2 / variance
        if nis > 100.0:
            return
        if nis > 16.0:
            noise += variance * ((nis / 16.0) ** steepness - 1.0)
        ekf.update(np.array([[measured]]), lambda _: row, lambda _: np.array([[expected]]), R=np.array([[noise]]))
        if own or not free.all():
            gain = ekf.K * free.reshape(-1, 1)
            keep = np.eye(SIZE) - gain @ row
            ekf.x = prior + gain * (measured - expected)
            ekf.P = keep @ covariance @ keep.T + gain * (noise - own) @ gain.T

    def free(self):
        """1 for what the present motion can tell apart, 0 for what it cannot."""
        z, p = self.force.x[:, 0], self.force.P
        free = np.ones(SIZE)
        free[4] = z[4] * self.stroke >= step.LEAST_STROKE
        free[7] = z[2] ** 2 >= 9.0 * p[2, 2]
        return free

    def deflection(self, measured, noise):
        self.update(measured, np.eye(SIZE)[0], self.force.x[0, 0], noise, self.free(), 0.5)

    def force_step(self, measured, noise, deflection_noise, dt):
        z, p = self.force.x[:, 0], self.force.P
        gradient, hessian = np.empty(SIZE), np.empty((SIZE, SIZE))
        blur = np.sqrt(COULOMB_SPEED**2 + 1.5 * (p[1, 1] + (z[2] * dt) ** 2 / 12.0))
        expected = force(z, REFERENCE, blur, gradient, hessian)
        unexplained = max(step.REVERSAL_SHARE * (z[9] + np.sqrt(p[9, 9])), step.LEAST_REVERSAL_FORCE)
        reversal = unexplained * np.exp(-(z[1] ** 2) / (step.REVERSAL_SPEED**2 + 2.0 * p[1, 1]))
        bent = np.trace(hessian @ p @ hessian @ p) / 2.0
        own = step.OWN_NOISE * gradient[0] ** 2 * deflection_noise
        total = noise + reversal**2 * max(1.0, step.REVERSAL_TIME / dt) + bent
        free = self.free()
        free[7] *= abs(z[2]) * np.sqrt(p[7, 7]) >= 0.2 * np.sqrt(noise)
        unsure = abs(abs(z[1]) - peak_speed(z[5], z[6])) < step.EITHER_SIDE * np.sqrt(p[1, 1])
        told = (gradient @ p)[6] ** 2 / (gradient @ p @ gradient + total + own) / p[6, 6]
        free[5:7] = not unsure or told <= step.MOST_TOLD
        self.update(measured, gradient, expected + np.trace(hessian @ p) / 2.0, total, free, 2.0, own)
        z = self.force.x[:, 0]
        z[4], z[5], z[7], z[9] = max(z[4], 20.0), max(z[5], 50.0), max(z[7], 0.0), max(z[9], 0.0)


def multisine(t):
    """4 mm at 0.05 Hz and 0.16 mm at 0.7 Hz about 10.5 mm: deflection, speed, acceleration."""
    w = 2.0 * np.pi * np.array([0.05, 0.7])
    amplitude = np.array([4e-3, 1.6e-4])
    x = 0.0105 + amplitude @ np.sin(w * t)
    return x, (amplitude * w) @ np.cos(w * t), -(amplitude * w**2) @ np.sin(w * t)


@pytest.mark.parametrize(("d2_std", "beyond", "teaches"), [(6e7, 0.5, False), (6e7, 8.0, True), (1e6, 0.5, True)])
def test_where_the_damper_may_be_at_its_greatest_force_or_not_no_force_tells_much_of_it(d2_std, beyond, teaches):
    z = np.array([0.01, 0.0, 0.0, 7.0, 250.0, 5500.0, -1.8e8, 0.3, 20.0, 0.3])
    w = peak_speed(z[5], z[6])
    z[1] = w * (1.0 + 0.05 * beyond)
    p = np.diag([1e-12, (0.05 * w) ** 2, 1e-4, 1e-4, 1.0, 50.0**2, d2_std**2, 1e-3, 1e-2, 1e-4])
    before, variance = z.copy(), np.diag(p).copy()
    expected = force(z, 0.01, COULOMB_SPEED, np.empty(SIZE), np.empty((SIZE, SIZE)))
    assert step.update_force(z, p, 0.01, expected + 0.3, 3e-4, 1e-12, 0.01, 0.01, np.zeros(3))
    assert (z[5] != before[5], p[5, 5] < variance[5]) == (teaches, teaches)
    assert (z[6] != before[6], p[6, 6] < variance[6]) == (teaches, teaches)
    assert p[3, 3] < variance[3]


@pytest.mark.parametrize("beyond", [-3.0, -1.0, -0.2, 0.2, 1.0, 3.0, -6.0, 6.0])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_near_the_greatest_force_of_the_damper_derivatives_are_those_of_its_mean_over_the_speed(beyond, side):
    z = np.array([0.0, 0.0, 0.0, 7.0, 250.0, 5500.0, -1.8e8, 0.3, 20.0, 0.0])
    w = peak_speed(z[5], z[6])
    std = 0.01 * w
    z[1] = side * (w + beyond * std)

    def damper(v):
        c = np.clip(v, -w, w)
        return z[5] * c + z[6] * c**3

    gradient, hessian = np.zeros(SIZE), np.zeros((SIZE, SIZE))
    force(z, 0.0, COULOMB_SPEED, gradient, hessian)
    step.soften_kink(z, std, gradient, hessian)
    apart = np.linspace(-8.0, 8.0, 16001)
    weight = np.exp(-0.5 * apart**2) / np.exp(-0.5 * apart**2).sum()
    values = damper(z[1] + std * apart)
    largest = 6.0 * abs(z[6]) * w * std  # of slopes within one standard deviation
    assert gradient[1] == pytest.approx(np.sum(weight * values * apart) / std, abs=0.02 * largest * (1.0 + beyond**2))
    mean = np.sum(weight * values) - damper(z[1])
    assert 0.5 * hessian[1, 1] * std**2 == pytest.approx(mean, abs=0.02 * largest * std)


def test_ten_thousand_steps_agree_with_filterpy_to_1e_9():
    rng = np.random.default_rng(5)
    z, p = np.array([*multisine(-0.01), *TRUTH[3:]]), np.diag(STD**2)
    reference = Reference(z, p)
    dt, monitor = 0.01, np.zeros(3)
    barred = 0
    for k in range(10_000):
        motion = multisine(k * dt)
        measured_x = motion[0] + 1e-5 * rng.standard_normal() * (8.0 if k % 997 == 500 else 1.0)
        measured_f = law(np.array([*motion, *TRUTH[3:]])) + 0.017 * rng.standard_normal()
        step.predict(z, p, dt, 1e-4)
        step.update_deflection(z, p, measured_x, 1e-10, 0.010, monitor)
        step.update_force(z, p, REFERENCE, measured_f, 0.017**2, 1e-10, dt, 0.010, monitor)
        reference.predict(dt, 1e-4)
        reference.deflection(measured_x, 1e-10)
        reference.force_step(measured_f, 0.017**2, 1e-10, dt)
        barred += z[2] ** 2 < 9.0 * p[2, 2]
    assert 0 < barred < 10_000
    std = np.sqrt(np.diag(p))
    assert z / std == pytest.approx(reference.force.x[:, 0] / std, rel=1e-9, abs=1e-9)
    assert p / np.outer(std, std) == pytest.approx(reference.force.P / np.outer(std, std), abs=1e-9)


def test_the_covariance_stays_symmetric_to_the_bit_and_positive():
    rng = np.random.default_rng(6)
    z, p, monitor = TRUTH.copy(), np.diag(STD**2), np.zeros(3)
    for _ in range(2_000):
        step.predict(z, p, 0.01, 1e-3)
        step.update_deflection(z, p, 0.010 + 1e-5 * rng.standard_normal(), 1e-10, 0.010, monitor)
        step.update_force(z, p, REFERENCE, law(TRUTH) + 0.017 * rng.standard_normal(), 3e-4, 1e-10, 0.01, 0.01, monitor)
    assert np.array_equal(p, p.T)
    std = np.sqrt(np.diag(p))
    assert np.linalg.eigvalsh(p / np.outer(std, std)).min() > -1e-12


def test_a_hundred_sigma_measurement_changes_nothing():
    z, p, monitor = TRUTH.copy(), np.diag(STD**2) * 1e-4, np.zeros(3)
    before = z.copy(), p.copy()
    assert not step.update_force(z, p, REFERENCE, law(TRUTH) + 100 * 0.017, 0.017**2, 0.0, 0.01, 0.01, monitor)
    assert not step.update_deflection(z, p, 0.010 + 1e-3, 1e-10, 0.010, monitor)
    assert np.array_equal(z, before[0])
    assert np.array_equal(p, before[1])
