# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parameters of the simulated rig; the defaults are the paper's rig."""

from dataclasses import dataclass

from vsa_common.config.configuration import group, quantities, quantity
from vsa_simulator.laws.config import ForceLaws
from vsa_simulator.rig.motion import ProfileConfig


@dataclass(frozen=True)
class TransmissionConfig:
    """Exponential spring (20), damper (5), mass of Table I: transmission 1 of the paper."""

    force_offset: float = quantity(16.39, "N", -100.0, 100.0, "F0 of (20)")
    k1: float = quantity(0.776, "N", 0.01, 100.0, "scale of the spring's exponential, (20)")
    k2: float = quantity(267.2, "1/m", 20.0, 1000.0, "rate of the spring's exponential, (20)")
    d1: float = quantity(4000.0, "N s/m", 10.0, 1e5, "damping at rest, (5)")
    d2: float = quantity(-1.089e8, "N s^3/m^3", -1e10, -1e4, "fall of the damping with speed, (5), Table I")
    coulomb_friction: float = quantity(0.3, "N", 0.0, 20.0, "d0 of (5)")
    inertia: float = quantity(0.3755, "kg", 0.1, 10.0, "mass that moves with the rod, Table I")
    tendon_stiffness: float = quantity(1e5, "N/m", 1e3, 1e8, "stiffness of the tendon")


@dataclass(frozen=True)
class SecondTransmissionConfig(TransmissionConfig):
    """Transmission 2 of the paper."""

    force_offset: float = quantity(8.269, "N", -100.0, 100.0, "F0 of (20)")
    k1: float = quantity(7.031, "N", 0.01, 100.0, "scale of the spring's exponential, (20)")
    k2: float = quantity(165.6, "1/m", 20.0, 1000.0, "rate of the spring's exponential, (20)")
    d2: float = quantity(-1.17e8, "N s^3/m^3", -1e10, -1e4, "fall of the damping with speed, (5), Table I")
    inertia: float = quantity(0.2295, "kg", 0.1, 10.0, "mass that moves with the rod, Table I")


@dataclass(frozen=True)
class JointConfig:
    """The shaft between the two tendons."""

    radius: float = quantity(0.0215, "m", 1e-3, 1.0, "radius R of the joint's pulley")
    inertia: float = quantity(1e-3, "kg m^2", 1e-6, 10.0, "inertia of the shaft and its load")
    damping: float = quantity(0.01, "N m s/rad", 0.0, 100.0, "damping of the shaft")
    equilibrium_angle: float = quantity(0.0, "rad", -1.5, 1.5, "angle about which the motors tension the tendons")


@dataclass(frozen=True)
class TorqueConfig:
    """External torque on the shaft: a constant and tones."""

    constant: float = quantity(0.0, "N m", -10.0, 10.0, "constant part, from the start")
    amplitudes: tuple[float, ...] = quantities((0.01, 0.005), "N m", 0.0, 10.0, "one a tone")
    frequencies: tuple[float, ...] = quantities((0.31, 1.1), "Hz", 1e-4, 100.0, "one a tone")
    phases: tuple[float, ...] = quantities((0.0, 1.0), "rad", -7.0, 7.0, "one a tone")
    fade_in: float = quantity(2.0, "s", 0.0, 100.0, "time in which the tones grow to their amplitude")


@dataclass(frozen=True)
class MotorConfig:
    """Motors as position actuators: critically damped, with limits of speed and position."""

    pulley_radius: float = quantity(0.010, "m", 1e-3, 0.1, "radius of the motor's pulley: tendon travel per radian")
    bandwidth: float = quantity(10.0, "Hz", 0.1, 1000.0, "bandwidth of the position loop")
    speed_limit: float = quantity(5.0, "rad/s", 0.01, 1000.0, "largest speed")
    lower_limit: float = quantity(-3.0, "rad", -80.0, 80.0, "lowest position")
    upper_limit: float = quantity(8.0, "rad", -80.0, 80.0, "highest position")
    watchdog: float = quantity(0.1, "s", 1e-3, 10.0, "without a command for this time motors hold their position")


@dataclass(frozen=True)
class SensorConfig:
    """Noise, resolution and range of the sensors; section VI."""

    force_noise_std: float = quantity(0.017, "N", 0.0, 10.0, "white noise of the force sensors")
    force_resolution: float = quantity(1e-4, "N", 0.0, 10.0, "step of the force sensors")
    force_range: float = quantity(200.0, "N", 1.0, 800.0, "force at which the sensors saturate")
    deflection_noise_std: float = quantity(1e-5, "m", 0.0, 1e-2, "white noise of the encoders")
    deflection_resolution: float = quantity(1e-5, "m", 1e-9, 1e-3, "deflection of one encoder count")
    encoder_start: int = quantity(0, "count", 0, 65535, "encoder count at zero deflection; 64500 wraps at 10 mm")
    angle_noise_std: float = quantity(1e-4, "rad", 0.0, 1.0, "white noise of the joint angle")
    torque_noise_std: float = quantity(1e-3, "N m", 0.0, 10.0, "white noise of the external torque")


@dataclass(frozen=True)
class SensorErrorConfig:
    """Systematic errors of the sensors of both transmissions; none by default."""

    force_delay: float = quantity(0.0, "s", 0.0, 1.0, "age of the force when the encoder is read")
    force_lowpass: float = quantity(0.0, "Hz", 0.0, 1e4, "cut-off of a first-order low-pass of the force; 0: none")
    force_hysteresis: float = quantity(0.0, "N", 0.0, 50.0, "greatest hysteresis of the force sensor; 0: none")
    force_hysteresis_span: float = quantity(5.0, "N", 0.01, 1000.0, "change of force in which a reversal is complete")
    force_drift: float = quantity(0.0, "N/min", -100.0, 100.0, "drift of the force sensor's zero")
    crosstalk: float = quantity(0.0, "", -0.5, 0.5, "share of the other transmission's force in each reading")
    encoder_cyclic: float = quantity(0.0, "m", 0.0, 1e-3, "amplitude of the encoder's cyclic error; 0: none")
    encoder_pitch: float = quantity(0.002, "m", 1e-5, 0.1, "deflection of one period of that error")
    frame_jitter: float = quantity(0.0, "s", 0.0, 0.01, "greatest random delay of a sample's frames, hence of stamps")


@dataclass(frozen=True)
class RigConfig(ForceLaws):
    """The whole rig: force laws of both transmissions and everything else."""

    rate_hz: int = quantity(1000, "Hz", 10, 10000, "samples a second")
    seed: int = quantity(0, "", 0, 2**31 - 1, "seed of the sensor noise")
    transmission_1: TransmissionConfig = group(TransmissionConfig)
    transmission_2: SecondTransmissionConfig = group(SecondTransmissionConfig)
    joint: JointConfig = group(JointConfig)
    torque: TorqueConfig = group(TorqueConfig)
    motors: MotorConfig = group(MotorConfig)
    sensors: SensorConfig = group(SensorConfig)
    sensor_errors: SensorErrorConfig = group(SensorErrorConfig)
    profile: ProfileConfig = group(ProfileConfig)
