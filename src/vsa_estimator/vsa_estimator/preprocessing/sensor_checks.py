# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Checks of every raw sample: stuck-at, run-length, variance-ratio, timestamp-burst and saturation."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_estimator.preprocessing.records import CHECKS
from vsa_estimator.preprocessing.sensor_flags import ENCODER_FAULT_MASK, SensorFlag
from vsa_estimator.tuning.preprocessing import (
    BURST_INTERVAL_CAP,
    BURST_LIMIT_NS,
    BURST_RATIO,
    BURST_SLOWDOWN,
    BURST_WINDOW,
    CONSTANT_ENCODER_TIME,
    ENCODER_FAULT_HOLD_NS,
    EXCEEDANCE_SHARE,
    FROZEN_TIME,
    MAX_REPEAT_SHARE,
    MIN_BURST,
    MIN_SUSPECT_RUN,
    REVERSAL_SHARE,
    RUN_LENGTH_LOG_ODDS,
    RUN_LENGTH_WINDOW,
    SEVERE_NOISE_RATIO,
    SLEW_INTERVAL_NS,
    SLEW_MEMORY,
    STUCK_ENCODER_TIME,
    STUCK_FORCE_TIME,
    SUSPECT_TIME_NS,
    UNDAMPED_SLEW,
    VARIANCE_GATE,
    VARIANCE_RATIO_CAP,
    VARIANCE_WINDOW,
    VIBRATION_AMPLITUDE,
    VIBRATION_END,
)

NO_VIBRATION = math.inf, 0.0  # of the encoder: that of the rod is below 5 um where it causes 1.3 N


def initial_checks() -> NDArray[Any]:
    """(1,) CHECKS before the first sample."""
    state = np.zeros(1, CHECKS)
    for stuck in (state["force_stuck"], state["encoder_stuck"]):
        stuck["value"], stuck["repeat_share"] = math.nan, 1.0
    for noise in (state["force_noise"], state["encoder_noise"]):
        noise["last"] = noise["before_last"] = noise["second_difference"] = math.nan
        noise["variance_ratio"] = noise["ratio"] = 1.0
    return state


@compiled
def check_sensors(
    checks: Any, limits: Any, stamp_ns: int, force: float, deflection: float, beyond_peak_speed: bool, period_ns: float
) -> int:
    """SensorFlag bits of a raw sample [ns, N, m]; `checks`, `limits`: a CHECKS and a LIMITS record.

    `beyond_peak_speed`: the rod is faster than v*; `period_ns`: mean sample period.
    """
    flags = check_stuck(checks, limits, stamp_ns, force, deflection)
    flags |= check_noise(checks, limits, force, deflection, beyond_peak_speed, period_ns)
    burst = check_burst(checks["burst"], stamp_ns)
    flags |= burst
    if burst == SensorFlag.BURST.value:
        checks["encoder_fault_until_ns"] = stamp_ns + ENCODER_FAULT_HOLD_NS
    if abs(force) >= limits["force_limit"]:
        flags |= SensorFlag.FORCE_SATURATED.value
    if abs(deflection) >= limits["deflection_limit"]:
        flags |= SensorFlag.DEFLECTION_SATURATED.value
    if flags & ENCODER_FAULT_MASK or stamp_ns < checks["encoder_fault_until_ns"]:
        flags |= SensorFlag.ENCODER_FAULT.value
    return flags


@compiled
def check_stuck(checks: Any, limits: Any, stamp_ns: int, force: float, deflection: float) -> int:
    """Flags of the stuck-at tests, each with the other sensor as evidence of motion, and of the run-length test."""
    flags, stuck = 0, checks["force_stuck"]
    if update_run(stuck, stamp_ns, force, deflection):
        flags |= SensorFlag.FORCE_REPEATED.value
        change = stuck["other_max"] - stuck["other_min"]
        if stamp_ns - stuck["since_ns"] > STUCK_FORCE_TIME * 1e9 and change > limits["deflection_change"]:
            flags |= SensorFlag.FORCE_STUCK.value
    stuck = checks["encoder_stuck"]
    if update_run(stuck, stamp_ns, deflection, force):
        duration = stamp_ns - stuck["since_ns"]
        if duration > CONSTANT_ENCODER_TIME * 1e9:
            flags |= SensorFlag.ENCODER_CONSTANT.value
        if duration > STUCK_ENCODER_TIME * 1e9 and stuck["other_max"] - stuck["other_min"] > limits["force_change"]:
            flags |= SensorFlag.ENCODER_STUCK.value
        if is_frozen(stuck, stamp_ns):
            flags |= SensorFlag.ENCODER_FROZEN.value
    return flags


@compiled
def update_run(stuck: Any, stamp_ns: int, value: float, other: float) -> bool:
    """Whether a sensor repeats its value; `other`: value of the other sensor; `stuck`: a STUCK record."""
    last = stuck["value"]
    repeated = value == last
    stuck["repeats"] = stuck["repeats"] + 1.0 if repeated else 0.0
    stuck["repeat_share"] += ((1.0 if repeated else 0.0) - stuck["repeat_share"]) / RUN_LENGTH_WINDOW
    reversed_ = 0.0
    if not repeated and not np.isnan(last):
        rising = value > last
        reversed_ = 1.0 if rising != stuck["is_rising"] else 0.0
        stuck["is_rising"] = rising
    stuck["reversal_share"] += (reversed_ - stuck["reversal_share"]) / RUN_LENGTH_WINDOW
    if not repeated:
        stuck["value"], stuck["since_ns"] = value, stamp_ns
        stuck["other_min"] = stuck["other_max"] = other
    elif other < stuck["other_min"]:
        stuck["other_min"] = other
    elif other > stuck["other_max"]:
        stuck["other_max"] = other
    return bool(repeated)


@compiled
def is_frozen(stuck: Any, stamp_ns: int) -> bool:
    """Run-length test: whether a value that dithers at rest has repeated itself for an improbably long run."""
    return bool(
        stuck["reversal_share"] > REVERSAL_SHARE
        and stuck["repeats"] * -np.log(min(stuck["repeat_share"], MAX_REPEAT_SHARE)) > RUN_LENGTH_LOG_ODDS
        and stamp_ns - stuck["since_ns"] > FROZEN_TIME * 1e9
    )


@compiled
def check_noise(
    checks: Any, limits: Any, force: float, deflection: float, beyond_peak_speed: bool, period_ns: float
) -> int:
    """Flags of the variance-ratio tests of both sensors."""
    flags, interval, decay = 0, max(1.0, period_ns / SLEW_INTERVAL_NS), 1e-9 * period_ns / SLEW_MEMORY
    slew = interval * limits["high_slew_force"], decay
    if update_noise(checks["force_noise"], force, limits["force_std"], slew, beyond_peak_speed) > 1.0:
        flags |= SensorFlag.FORCE_NOISY.value
    ratio = update_noise(checks["encoder_noise"], deflection, limits["deflection_std"], NO_VIBRATION, False)
    if ratio > 1.0:
        flags |= SensorFlag.ENCODER_NOISY.value
    if ratio > SEVERE_NOISE_RATIO:
        flags |= SensorFlag.ENCODER_NOISE_SEVERE.value
    return flags


@compiled
def update_noise(noise: Any, value: float, std: float, slew: tuple[float, float], beyond_peak_speed: bool) -> float:
    """Variance-ratio test: standard deviation of a sensor's white noise relative to `std`, 1 unless it is noisy.

    Consecutive second differences of white noise have the covariance -4 std^2; those of a smooth motion have a
    positive one. Beyond v* nothing damps the rod: after a motion of a high slope, or while it is `beyond_peak_speed`,
    it vibrates with its tendon. The threshold allows for this residual vibration. `slew`: the high slope per sample,
    and the share by which the steepest slope decays in a sample. `noise`: a NOISE record.
    """
    high_slew, decay = slew
    last, steepest = noise["last"], noise["steepest"]
    difference = value - 2.0 * last + noise["before_last"]
    vibrates = beyond_peak_speed or steepest > (VIBRATION_END if noise["is_vibrating"] else 1.0) * high_slew
    least = UNDAMPED_SLEW * high_slew if beyond_peak_speed else 0.0
    vibration = VIBRATION_AMPLITUDE * max(steepest, least) if vibrates else 0.0
    product = -difference * noise["second_difference"] / (4.0 * (std * std + vibration * vibration))
    noise["last"], noise["before_last"] = value, last
    noise["second_difference"], noise["is_vibrating"] = difference, vibrates
    noise["ratio"] = 1.0
    if np.isnan(product):
        return 1.0
    noise["slope"] += (value - last - noise["slope"]) / VARIANCE_WINDOW
    noise["steepest"] = max(abs(noise["slope"]), steepest * (1.0 - decay))
    exceeds = 1.0 if product > VARIANCE_GATE else 0.0
    noise["exceedance_share"] += (exceeds - noise["exceedance_share"]) / VARIANCE_WINDOW
    ratio = min(max(product, 0.0), VARIANCE_RATIO_CAP)
    noise["variance_ratio"] += (ratio - noise["variance_ratio"]) / VARIANCE_WINDOW
    if noise["exceedance_share"] > EXCEEDANCE_SHARE:
        noise["ratio"] = np.sqrt(max(noise["variance_ratio"], 1.0))
    return float(noise["ratio"])


@compiled
def check_burst(burst: Any, stamp_ns: int) -> int:
    """TIMING_SUSPECT once in a run of samples that arrive together, BURST while it is too long, else 0.

    `burst`: a BURST record.
    """
    step = stamp_ns - burst["last_stamp_ns"]
    burst["last_stamp_ns"] = stamp_ns
    burst["samples"] += 1.0
    if burst["samples"] < 3.0:
        burst["interval_ns"] = step
        return 0
    mean = burst["interval_ns"]
    run = burst["run"] + 1.0 if step < BURST_RATIO * mean else 0.0
    burst["run"] = run
    window = min(burst["samples"], BURST_WINDOW) * (BURST_SLOWDOWN if run > 0.0 else 1.0)
    burst["interval_ns"] += (min(step, BURST_INTERVAL_CAP * mean) - mean) / window
    mean = burst["interval_ns"]
    if run >= MIN_BURST and run * mean > BURST_LIMIT_NS:
        return SensorFlag.BURST.value
    suspect = run == max(MIN_SUSPECT_RUN, np.floor(SUSPECT_TIME_NS / mean) + 1.0)
    return SensorFlag.TIMING_SUSPECT.value if suspect else 0
