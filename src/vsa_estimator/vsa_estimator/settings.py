# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parameters of the estimator, in SI; each is a ROS parameter of the same name."""

import math
from dataclasses import dataclass

from vsa_common.config.configuration import (
    FRAME_PREFIX,
    ConfigurationError,
    choice,
    group,
    quantities,
    quantity,
    string,
)


@dataclass(frozen=True)
class Posterior:
    """Coefficients of a previous run with their covariance, in SI, as ~/save_coefficients and `identify` write them.

    The estimator starts from them instead of the other start values. Names that it does not have are ignored.
    """

    names: tuple[str, ...] = string(
        ("",), "coefficients of a previous run, in the order of values and covariance; empty: none", tunable=True
    )
    values: tuple[float, ...] = quantities((0.0,), "SI", -1e30, 1e30, "one for each of names", tunable=True)
    covariance: tuple[float, ...] = quantities((0.0,), "SI", -1e30, 1e30, "of values, row by row", tunable=True)
    deflection_reference: float = quantity(
        0.0, "m", -10.0, 10.0, "deflection at which ln_stiffness_reference holds", tunable=True
    )

    def __post_init__(self) -> None:
        if not self:
            return
        count = len(self.names)
        for name, expected in (("values", count), ("covariance", count * count)):
            found = len(getattr(self, name))
            if found != expected:
                raise ConfigurationError(f"initial.posterior.{name}: {found} numbers, expected {expected}")

    def __bool__(self) -> bool:
        """Whether there are coefficients."""
        return any(self.names)


@dataclass(frozen=True)
class Initial:
    """Start values of the coefficients with their standard deviations; changed ones apply from the next reset on."""

    k2: float = quantity(267.2, "1/m", 20.0, 5000.0, "growth of the exponential spring, eq. (2)", tunable=True)
    k2_std: float = quantity(90.0, "1/m", 1e-3, 5000.0, "standard deviation of initial.k2", tunable=True)
    d1: float = quantity(4000.0, "N s/m", 50.0, 1e6, "linear coefficient of the damper, eq. (5)", tunable=True)
    d1_std: float = quantity(2400.0, "N s/m", 1e-3, 1e6, "standard deviation of initial.d1", tunable=True)
    d2: float = quantity(-1.089e8, "N s^3/m^3", -1e12, 0.0, "cubic coefficient of the damper, eq. (5)", tunable=True)
    d2_std: float = quantity(1.0e8, "N s^3/m^3", 1.0, 1e12, "standard deviation of initial.d2", tunable=True)
    inertia: float = quantity(0.3755, "kg", 0.0, 1e5, "moving mass of the transmission, eq. (6)", tunable=True)
    inertia_std: float = quantity(0.4, "kg", 1e-6, 1e5, "standard deviation of initial.inertia", tunable=True)
    force_offset: float = quantity(16.39, "N", -1e4, 1e4, "F0 of the spring, eq. (2)", tunable=True)
    force_offset_std: float = quantity(5.0, "N", 1e-4, 1e4, "standard deviation of initial.force_offset", tunable=True)
    coulomb_friction: float = quantity(0.3, "N", 0.0, 1e3, "d0 of the damper, eq. (5)", tunable=True)
    coulomb_friction_std: float = quantity(
        0.3, "N", 1e-4, 1e3, "standard deviation of initial.coulomb_friction", tunable=True
    )
    posterior: Posterior = group(Posterior)


@dataclass(frozen=True)
class EstimatorConfig:
    """Parameters of the estimator of one transmission."""

    formulation: str = choice(
        "force",
        ("force", "force_rate"),
        "force measures the force itself; force_rate is the paper's filter, eqs. (14) to (17) corrected",
    )
    elastic_law: str = choice(
        "automatic",
        ("exponential", "automatic"),
        "exponential: eq. (2); automatic: that law until the data refute it, then a law of any form",
    )
    filter_rate: float = quantity(
        100.0, "Hz", 10.0, 1000.0, "rate of the filter; faster samples are averaged, the output keeps their rate"
    )
    force_noise_std: float = quantity(
        0.017,
        "N",
        1e-6,
        100.0,
        "white noise of one force sample (section VI); adapted within 1/4 to 4 of it",
        tunable=True,
    )
    deflection_noise_std: float = quantity(
        1e-5,
        "m",
        1e-9,
        1e-2,
        "white noise of one deflection sample (section VI); adapted within 1/4 to 4 of it",
        tunable=True,
    )
    deflection_resolution: float = quantity(1e-5, "m", 0.0, 1e-2, "quantisation step of the encoder; 0: none")
    force_limit: float = quantity(
        200.0, "N", 1e-3, 1e6, "saturation of the force sensor; no coefficient is updated from there on", tunable=True
    )
    deflection_limit: float = quantity(
        0.020, "m", 1e-6, 10.0, "end of the travel; no coefficient is updated from there on", tunable=True
    )
    initial: Initial = group(Initial)

    @property
    def quantisation_std(self) -> float:
        """Standard deviation of the quantisation error of the encoder [m]."""
        return self.deflection_resolution / math.sqrt(12.0)

    @property
    def deflection_std(self) -> float:
        """Standard deviation of one deflection sample: white noise and quantisation [m]."""
        return math.hypot(self.deflection_noise_std, self.quantisation_std)


@dataclass(frozen=True)
class FlightRecorderConfig:
    """Samples around an event, for `replay`."""

    folder: str = string(
        "", "folder of the CSV files with the samples around a reset or a reported fault; empty: none", tunable=True
    )
    samples: int = quantity(
        30_000, "", 100, 1_000_000, "samples kept in memory: 30 s at 1 kHz, 24 bytes each", tunable=True
    )
    after: float = quantity(5.0, "s", 1.0, 60.0, "duration recorded after the event", tunable=True)
    files: int = quantity(20, "", 1, 10_000, "files kept for one transmission; the oldest are deleted", tunable=True)


@dataclass(frozen=True)
class NodeConfig(EstimatorConfig):
    """Parameters of the estimator node."""

    frame_prefix: str = string("", FRAME_PREFIX)
    transmission: str = string(
        "transmission_1", "transmission to estimate: first part of its topic names, and frame_id after frame_prefix"
    )
    state_rate: float = quantity(50.0, "Hz", 0.1, 1000.0, "rate of estimator_state", tunable=True)
    pairing_tolerance: float = quantity(
        0.0, "s", 0.0, 0.1, "greatest difference between the stamps of force and encoder of one sample", tunable=True
    )
    reorder_window: float = quantity(
        0.1,
        "s",
        0.0,
        1.0,
        "delay of one sensor behind the other after which an unpaired stamp is dropped",
        tunable=True,
    )
    future_tolerance: float = quantity(
        0.1, "s", 0.0, 10.0, "stamps further ahead of the node's clock are rejected", tunable=True
    )
    reliability: str = choice(
        "reliable", ("reliable", "best_effort"), "QoS of the sensor subscriptions; best_effort matches every publisher"
    )
    coefficients_file: str = string(
        "", "parameter file of ~/save_coefficients and ~/load_coefficients where the call names none", tunable=True
    )
    flight_recorder: FlightRecorderConfig = group(FlightRecorderConfig)
