# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Noise of both sensors and process noise of the motion, adapted from the data."""

from vsa_estimator.filter.measurement_noise import NoiseLevel
from vsa_estimator.filter.process_noise import JerkDensity
from vsa_estimator.settings import EstimatorConfig
from vsa_estimator.tuning.filter import MIN_JERK_DENSITY, MIN_JERK_DENSITY_WITH_INERTIA
from vsa_estimator.tuning.supervisor import NOISE_MEMORY


class NoiseAdaptation:
    """Running noise levels of force and deflection, and the running density of the white jerk."""

    def __init__(self, config: EstimatorConfig) -> None:
        """Start from the configured noise."""
        self._config = config
        self.force, self.deflection = _force_level(config), _deflection_level(config)
        self.jerk = JerkDensity()

    def reconfigure(self, config: EstimatorConfig) -> None:
        """Start again from a configured noise that has changed; the jerk density stays."""
        before, self._config = self._config, config
        if config.force_noise_std != before.force_noise_std:
            self.force = _force_level(config)
        if config.deflection_noise_std != before.deflection_noise_std:
            self.deflection = _deflection_level(config)

    def restart(self, deflection: float, variance: float) -> None:
        """Let no difference reach across a gap; the motion restarts at a deflection [m] of this variance [m^2]."""
        self.jerk.restart(deflection, variance)
        self.deflection.interrupt()
        self.force.interrupt()

    def refresh(self, inertia_negligible: bool) -> None:
        """Renew the noise levels and the jerk density."""
        self.force.refresh()
        self.deflection.refresh()
        self.jerk.refresh(MIN_JERK_DENSITY if inertia_negligible else MIN_JERK_DENSITY_WITH_INERTIA)


def _force_level(config: EstimatorConfig) -> NoiseLevel:
    return NoiseLevel(config.force_noise_std, 0.0, int(NOISE_MEMORY * config.filter_rate))


def _deflection_level(config: EstimatorConfig) -> NoiseLevel:
    return NoiseLevel(config.deflection_std, config.quantisation_std, int(NOISE_MEMORY * config.filter_rate))
