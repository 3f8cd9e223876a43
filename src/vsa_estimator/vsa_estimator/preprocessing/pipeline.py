# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Path of a raw sample to the filter: validation, timestamp filter, sensor checks, outlier filter, decimator."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from vsa_common.accel import compiled
from vsa_estimator.preprocessing.decimator import (
    Decimated,
    add_sample,
    finished_blocks,
    initial_decimator,
    is_decimating,
)
from vsa_estimator.preprocessing.outlier_filter import accept, initial_outlier
from vsa_estimator.preprocessing.records import LIMITS, PIPELINE_STATE
from vsa_estimator.preprocessing.sensor_checks import check_sensors, initial_checks
from vsa_estimator.preprocessing.sensor_flags import EXCLUDE_FROM_UPDATE, SensorFlag
from vsa_estimator.preprocessing.timestamp_filter import corrected_stamp, initial_timestamps
from vsa_estimator.preprocessing.validation import ACCEPT, initial_validation, validate
from vsa_estimator.settings import EstimatorConfig
from vsa_estimator.tuning.preprocessing import (
    FRICTION_BOUND,
    HIGH_SLEW_FORCE,
    STUCK_DEFLECTION_NOISE,
    STUCK_DEFLECTION_STEPS,
    STUCK_FORCE_FRICTION,
    STUCK_FORCE_NOISE,
)


@compiled
def preprocess(state: NDArray[Any], stamp_ns: int, force: float, deflection: float) -> tuple[int, int, int, int]:
    """Outcome of `validate`, SensorFlag bits, instant [ns] and count of finished blocks of a sample [ns, N, m].

    `state`: (1,) PIPELINE_STATE. All but the outcome are 0 unless it is ACCEPT.
    """
    now = state[0]
    outcome = validate(now["validation"], stamp_ns, force, deflection)
    if outcome != ACCEPT:
        now["timestamps"]["clock"]["lost"] += 1  # used where the driver counts
        return outcome, 0, 0, 0
    decimator = now["decimator"]
    instant_ns = corrected_stamp(now["timestamps"], stamp_ns, deflection)
    flags = check_sensors(
        now["checks"], now["limits"], instant_ns, force, deflection, now["beyond_peak_speed"], decimator["period_ns"]
    )
    force_usable, deflection_usable = flags & EXCLUDE_FROM_UPDATE == 0, True
    if is_decimating(decimator["period_ns"], decimator["span_ns"]):
        if force_usable and not accept(now["force_outliers"], force):
            flags |= SensorFlag.FORCE_OUTLIER.value
            force_usable = False
        if not accept(now["deflection_outliers"], deflection):
            flags |= SensorFlag.DEFLECTION_OUTLIER.value
            deflection_usable = False
    finished = add_sample(decimator, instant_ns, deflection, force, deflection_usable, force_usable)
    return outcome, flags, instant_ns, finished


class Pipeline:
    """Preprocessing of one transmission's samples; `state`, a (1,) PIPELINE_STATE, is the argument of `preprocess`."""

    def __init__(self, config: EstimatorConfig) -> None:
        """Limits and noise from the configuration."""
        self._config = config
        self.state = _initial_state(config)
        self._set_views()

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a copy, whose views refer to its own state."""
        self.__dict__.update(state)
        self._set_views()

    def _set_views(self) -> None:
        """Views of what every filter step reads: (1,) arrays."""
        decimator, checks = self.state["decimator"], self.state["checks"]
        self._clock = self.state["timestamps"]["clock"]
        self._decimator, self._period_ns, self._span_ns = decimator, decimator["period_ns"], decimator["span_ns"]
        self._force_ratio, self._deflection_ratio = checks["force_noise"]["ratio"], checks["encoder_noise"]["ratio"]

    def reset(self) -> None:
        """Clear the state except for the validation, since stamps remain increasing, and for the counting driver."""
        validation, is_counted = self.state["validation"].copy(), bool(self._clock["is_counted"][0])
        self.state[:] = _initial_state(self._config)
        self.state["validation"], self._clock["is_counted"] = validation, is_counted

    def count_lost(self, lost: int) -> None:
        """The driver counts the samples that are lost: `lost` since the last sample."""
        self._clock["is_counted"] = True
        self._clock["lost"] += lost

    def reconfigure(self, config: EstimatorConfig) -> None:
        """Apply noise and limits of another configuration; the state of the samples stays."""
        self._config = config
        initial = _initial_state(config)
        self.state["limits"] = initial["limits"]
        for record in ("force_outliers", "deflection_outliers"):
            self.state[record]["gate"] = initial[record]["gate"]
        for bound in ("max_force", "max_deflection"):
            self.state["validation"][bound] = initial["validation"][bound]

    def set_beyond_peak_speed(self, beyond_peak_speed: bool) -> None:
        """Set whether the rod is faster than v*, where its residual vibration is not sensor noise."""
        self.state["beyond_peak_speed"] = beyond_peak_speed

    def finished(self, count: int) -> list[Decimated]:
        """The `count` blocks that the last sample has finished."""
        return finished_blocks(self._decimator[0], count) if count else []

    @property
    def period_ns(self) -> float:
        """Running mean of the sample period [ns]; 0 before the second sample."""
        return float(self._period_ns[0])

    @property
    def is_decimating(self) -> bool:
        """Whether blocks hold several samples."""
        return is_decimating(float(self._period_ns[0]), float(self._span_ns[0]))

    @property
    def force_noise_ratio(self) -> float:
        """Standard deviation of the force's noise relative to the configured one; 1 unless noisy."""
        return float(self._force_ratio[0])

    @property
    def deflection_noise_ratio(self) -> float:
        """Standard deviation of the encoder's noise relative to the configured one; 1 unless noisy."""
        return float(self._deflection_ratio[0])


def _initial_state(config: EstimatorConfig) -> NDArray[Any]:
    """(1,) PIPELINE_STATE before the first sample."""
    state = np.zeros(1, PIPELINE_STATE)
    state["validation"] = initial_validation(config.force_limit, config.deflection_limit)
    state["timestamps"] = initial_timestamps()
    state["limits"] = _limits(config)
    state["checks"] = initial_checks()
    state["force_outliers"] = initial_outlier(config.force_noise_std)
    state["deflection_outliers"] = initial_outlier(config.deflection_std)
    state["decimator"] = initial_decimator(config.filter_rate)
    return state


def _limits(config: EstimatorConfig) -> NDArray[Any]:
    """(1,) LIMITS of the sensor checks."""
    friction = config.initial.coulomb_friction + FRICTION_BOUND * config.initial.coulomb_friction_std
    limits = np.zeros(1, LIMITS)
    limits["force_std"], limits["deflection_std"] = config.force_noise_std, config.deflection_std
    limits["high_slew_force"] = HIGH_SLEW_FORCE * config.force_noise_std
    limits["force_change"] = STUCK_FORCE_NOISE * config.force_noise_std + STUCK_FORCE_FRICTION * friction
    limits["deflection_change"] = (
        STUCK_DEFLECTION_NOISE * config.deflection_noise_std + STUCK_DEFLECTION_STEPS * config.deflection_resolution
    )
    limits["force_limit"], limits["deflection_limit"] = config.force_limit, config.deflection_limit
    return limits
