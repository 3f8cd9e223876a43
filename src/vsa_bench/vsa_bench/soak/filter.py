# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Long runs without a bus: random frames through the driver's parsers, hours of motion through the filter."""

import os
import time
from collections.abc import Iterator
from typing import Any, TypeVar

import numpy as np
from vsa_bench.harness.usage import resident_mb
from vsa_common.config.configuration import build, node_values, parameters
from vsa_common.damper import peak_speed
from vsa_common.terminal import progress
from vsa_common.types import Array
from vsa_driver.acquisition.channel import Measurement
from vsa_driver.acquisition.router import Router
from vsa_driver.can.bus import Frame
from vsa_driver.can.frames import RIG_DBC, FrameSet
from vsa_driver.settings import DriverSettings
from vsa_estimator.estimator import Estimator
from vsa_estimator.settings import EstimatorConfig
from vsa_simulator.rig.config import RigConfig
from vsa_tools.demo.parameters import paper_rig

Config = TypeVar("Config")
CHUNK = 6000  # samples between two checks of the covariance
RATE_HZ = 25
MAPPED_IDS = (0x101, 0x102, 0x110, 0x120, 0x200)
MIN_EIGENVALUE = -1e-9  # of the correlation matrix: zero within rounding


def random_frames(count: int, seed: int = 1) -> Iterator[Frame]:
    """Frames of any identifier, length and content, half of them under an identifier that the driver maps."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        mapped = rng.random() < 0.5
        yield Frame(
            arbitration_id=int(rng.choice(MAPPED_IDS)) if mapped else int(rng.integers(1 << 11)),
            is_extended_id=bool(rng.random() < 0.1),
            is_error_frame=bool(rng.random() < 0.01),
            is_remote_frame=bool(rng.random() < 0.01),
            data=rng.bytes(int(rng.integers(0, 9))),
            timestamp=float(rng.choice([0.0, 1.7e9, 1e300, -1.0, float("nan")])),
        )


def soak_frames(count: int, seed: int = 1) -> dict[str, Any]:
    """Random frames through the driver's parsers and on into an estimator; counts and memory growth."""
    router = Router(FrameSet(RIG_DBC), DriverSettings())
    estimators = {name: Estimator(EstimatorConfig()) for name in router.transmissions}
    rng = np.random.default_rng(seed)
    stamp_ns, estimated, invalid, first_mb = 1_700_000_000_000_000_000, 0, 0, 0.0
    with progress(count, "random frames") as bar:
        for number, frame in enumerate(random_frames(count, seed)):
            stamp_ns += int(rng.integers(-1_000, 2_000_000))
            for sample in router.add(frame, stamp_ns):
                if isinstance(sample, Measurement):
                    estimate = estimators[sample.transmission].add(sample.stamp_ns, sample.force, sample.deflection)
                    estimated += 1
                    invalid += estimate is not None and not np.isfinite(estimate).all()
            if number == count // 5:
                first_mb = resident_mb(os.getpid())
            if number % CHUNK == 0:
                bar.advance(min(CHUNK, count - number), "random frames")
                invalid += any(not has_valid_covariance(estimator) for estimator in estimators.values())
    return {
        "frames": count,
        "samples": estimated,
        "unsound": invalid,
        "rss_growth_mb": round(resident_mb(os.getpid()) - first_mb, 2),
    }


def soak_filter(hours: float, seed: int = 1) -> dict[str, Any]:
    """Hours of the rig's motion through the estimator of its first transmission; counts, worst error, memory growth."""
    rng = np.random.default_rng(seed)
    rig = _configured(RigConfig, "rig_simulator")
    estimator = Estimator(_configured(EstimatorConfig, "estimator_1"))
    samples = round(hours * 3600 * RATE_HZ)
    invalid, wrong, first_mb, worst, begin = 0, 0, 0.0, 0.0, time.monotonic()
    with progress(samples, "filter") as bar:
        for first in range(0, samples, CHUNK):
            count = min(CHUNK, samples - first)
            force, deflection, stiffness = samples_of_motion(rig, (first + np.arange(count)) / RATE_HZ, rng)
            for k, measured in enumerate(zip(force.tolist(), deflection.tolist(), strict=True)):
                stamp_ns = 1_700_000_000_000_000_000 + (first + k) * (1_000_000_000 // RATE_HZ)
                estimate = estimator.add(stamp_ns, *measured)
            assert estimate is not None
            invalid += not (np.isfinite(estimate).all() and has_valid_covariance(estimator))
            error = abs(estimate.stiffness / float(stiffness[-1]) - 1.0)
            if first > 60 * RATE_HZ and estimate.stiffness_valid:
                worst = max(worst, error)
                wrong += error > max(0.01, 4.0 * estimate.stiffness_variance**0.5 / estimate.stiffness)
            if first <= samples // 20:
                first_mb = resident_mb(os.getpid())
            bar.advance(count, "filter")
    state = estimator.state()
    return {
        "simulated_hours": hours,
        "samples_fused": state.samples_fused,
        "unsound": invalid,
        "wrong_but_valid": wrong,
        "worst_stiffness_error": round(worst, 5),
        "resets": state.reset_count,
        "rss_growth_mb": round(resident_mb(os.getpid()) - first_mb, 2),
        "us_per_sample": round((time.monotonic() - begin) / samples * 1e6, 1),
    }


def _configured(config_class: type[Config], node: str, **changes: Any) -> Config:
    names = {parameter.name for parameter in parameters(config_class)}
    values = {name: value for name, value in node_values(paper_rig(), node, config_class).items() if name in names}
    return build(config_class, {**values, **changes})


def samples_of_motion(rig: RigConfig, time: Array, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """Measured force [N] and deflection [m] of transmission_1 on the rig's motion, and the true stiffness [N/m].

    Eqs. (2), (3), (5) and (6) in closed form, which is faster than the integration of the rig.
    """
    spring, motion, sensors = rig.transmission_1, rig.profile, rig.sensors
    x, v, a = np.full_like(time, motion.centre), np.zeros_like(time), np.zeros_like(time)
    for amplitude, frequency, phase in zip(motion.amplitudes, motion.frequencies, motion.phases, strict=True):
        w = 2.0 * np.pi * frequency
        x += amplitude * np.sin(w * time + phase)
        v += amplitude * w * np.cos(w * time + phase)
        a -= amplitude * w * w * np.sin(w * time + phase)
    fastest = peak_speed(spring.d1, spring.d2)
    c = np.clip(v, -fastest, fastest)
    friction = spring.coulomb_friction * np.tanh(v / rig.friction.smoothing_speed)
    elastic = spring.k1 * np.exp(spring.k2 * x)
    force = spring.force_offset + elastic + spring.d1 * c + spring.d2 * c**3 + friction + spring.inertia * a
    force += sensors.force_noise_std * rng.standard_normal(time.size)
    step = sensors.deflection_resolution
    deflection = np.round((x + sensors.deflection_noise_std * rng.standard_normal(time.size)) / step) * step
    return force, deflection, spring.k2 * elastic


def has_valid_covariance(estimator: Estimator) -> bool:
    """Whether the coefficients' covariance is finite, symmetric to the bit and positive."""
    covariance = np.array(estimator.state().coefficient_covariance).reshape(7, 7)
    if not np.isfinite(covariance).all() or not (covariance == covariance.T).all():
        return False
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    scale = np.where(std > 0.0, std, 1.0)
    return bool(np.linalg.eigvalsh(covariance / np.outer(scale, scale))[0] > MIN_EIGENVALUE)
