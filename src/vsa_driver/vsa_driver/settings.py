# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parameters of the driver: bus, mapping of signals, calibration, motor limits."""

from dataclasses import dataclass

from vsa_common.config.configuration import FRAME_PREFIX, ConfigurationError, flag, group, quantity, string
from vsa_driver.can.bus import BusConfig

MOTORS = 2  # of an antagonistic joint
_FORCE = "message.signal of the DBC that carries the rod force"
_ENCODER = "message.signal that carries the encoder; where the message is another one, both are merged into one sample"
_COUNTER = "message.signal that numbers the samples; empty: the device sends none"


@dataclass(frozen=True)
class TransmissionSettings:
    """Signals and calibration of one transmission.

    force = force_scale * (+- signal) + force_offset, tension > 0;
    deflection = encoder_scale * (+- signal) + encoder_offset, elongation > 0.
    """

    force_signal: str = string("Transmission1.Force", _FORCE)
    encoder_signal: str = string("Transmission1.EncoderCount", _ENCODER)
    counter_signal: str = string("Transmission1.RollingCounter", _COUNTER)
    force_scale: float = quantity(1.0, "N per unit of the signal", 1e-12, 1e12, "from `./vsa calibrate`")
    force_offset: float = quantity(0.0, "N", -1e5, 1e5, "from `./vsa calibrate`")
    force_reversed: bool = flag(False, "the signal decreases with increasing tension")
    force_limit: float = quantity(
        200.0, "N", 1e-3, 1e6, "full scale of the sensor; at and beyond it counted as saturated", tunable=True
    )
    encoder_scale: float = quantity(1e-5, "m per unit of the signal", 1e-12, 1e6, "travel of the rod a count")
    encoder_offset: float = quantity(0.0, "m", -10.0, 10.0, "deflection where the encoder reads zero")
    encoder_reversed: bool = flag(False, "the count decreases with elongation")
    encoder_bits: int = quantity(0, "bit", 0, 64, "width after which the count wraps; 0: that of the signal")
    deflection_min: float = quantity(-0.001, "m", -10.0, 10.0, "least travel; beyond it counted as saturated")
    deflection_max: float = quantity(0.0205, "m", -10.0, 10.0, "greatest travel; beyond it counted as saturated")

    def __post_init__(self) -> None:
        if self.deflection_min >= self.deflection_max:
            raise ConfigurationError(
                f"deflection_min = {self.deflection_min!r} m: must be below deflection_max = {self.deflection_max!r} m"
            )


@dataclass(frozen=True)
class SecondTransmissionSettings(TransmissionSettings):
    """As TransmissionSettings, with the signals of transmission 2."""

    force_signal: str = string("Transmission2.Force", _FORCE)
    encoder_signal: str = string("Transmission2.EncoderCount", _ENCODER)
    counter_signal: str = string("Transmission2.RollingCounter", _COUNTER)


@dataclass(frozen=True)
class JointSettings:
    """Name of the joint, and signals of its shaft; an empty one is not measured and not published."""

    name: str = string("joint", "name in joint_states, and frame_id of the measurements at the shaft")
    angle_signal: str = string("Joint.Angle", "message.signal of the joint angle")
    angle_scale: float = quantity(1.0, "rad per unit of the signal", -1e6, 1e6, "negative for the opposite sense")
    torque_signal: str = string("Joint.ExternalTorque", "message.signal of the external torque")
    torque_scale: float = quantity(1.0, "N m per unit of the signal", -1e6, 1e6, "negative for the opposite sense")
    counter_signal: str = string("Joint.RollingCounter", "message.signal that numbers the frames; empty: none")


@dataclass(frozen=True)
class MotorSettings:
    """Names and signals of the motors and limits of their commands."""

    names: tuple[str, ...] = string(("motor_1", "motor_2"), "names in motor_states and motor_commands")
    position_signals: tuple[str, ...] = string(
        ("MotorState.Position1", "MotorState.Position2"), "message.signal of each measured position; empty: none"
    )
    holding_signal: str = string("MotorState.WatchdogHolding", "message.signal of the device's watchdog; empty: none")
    counter_signal: str = string("MotorState.RollingCounter", "message.signal that numbers the frames; empty: none")
    command_signals: tuple[str, ...] = string(
        ("MotorCommand.Position1", "MotorCommand.Position2"), "message.signal of each commanded position; empty: none"
    )
    command_counter_signal: str = string(
        "MotorCommand.RollingCounter", "message.signal to number commands; empty: none"
    )
    scale: float = quantity(1.0, "rad per unit of the signals", 1e-9, 1e6, "of positions and commands alike")
    position_min: float = quantity(-3.0, "rad", -1e4, 1e4, "commands below are refused", tunable=True)
    position_max: float = quantity(8.0, "rad", -1e4, 1e4, "commands above are refused", tunable=True)
    speed_max: float = quantity(
        5.0, "rad/s", 1e-3, 1e4, "limit of the speed of the commands that are sent", tunable=True
    )
    command_timeout: float = quantity(
        0.2, "s", 0.01, 10.0, "without a command for this time no frame is sent", tunable=True
    )
    command_rate: float = quantity(100.0, "Hz", 1.0, 1000.0, "of command frames while armed", tunable=True)

    def __post_init__(self) -> None:
        if self.position_min >= self.position_max:
            raise ConfigurationError(
                f"position_min = {self.position_min!r} rad: must be below position_max = {self.position_max!r} rad"
            )
        if len(set(self.names)) != MOTORS or not all(self.names):
            raise ConfigurationError(f"motors.names = {list(self.names)!r}: must be {MOTORS} different names")
        for name in ("position_signals", "command_signals"):
            given = [signal for signal in getattr(self, name) if signal]
            if len(given) not in (0, MOTORS):
                raise ConfigurationError(f"{name} = {given!r}: must be {MOTORS} signals, or none")


@dataclass(frozen=True)
class DriverSettings:
    """All parameters of the driver."""

    frame_prefix: str = string("", FRAME_PREFIX)
    bus: BusConfig = group(BusConfig)
    dbc: str = string("package://vsa_driver/config/vsa_rig.dbc", "DBC file: a path, or package://package/path")
    transmissions: tuple[str, ...] = string(("transmission_1", "transmission_2"), "those that are connected")
    transmission_1: TransmissionSettings = group(TransmissionSettings)
    transmission_2: SecondTransmissionSettings = group(SecondTransmissionSettings)
    joint: JointSettings = group(JointSettings)
    motors: MotorSettings = group(MotorSettings)
    counters_rate: float = quantity(
        10.0, "Hz", 0.1, 100.0, "of capture_counters, the sequence numbers of the samples", tunable=True
    )
    silence: float = quantity(
        0.1, "s", 0.005, 60.0, "without a sample for this time a transmission has timed out", tunable=True
    )
    tare_spread: float = quantity(
        0.1, "N", 1e-4, 100.0, "standard deviation of the force above which tare is refused", tunable=True
    )

    def __post_init__(self) -> None:
        if not self.joint.name:
            raise ConfigurationError("joint.name = '': must not be empty")
        names = list(self.transmissions)
        if sorted(names) not in (["transmission_1"], ["transmission_2"], ["transmission_1", "transmission_2"]):
            raise ConfigurationError(f"transmissions = {names!r}: must be transmission_1, transmission_2 or both")

    def transmission(self, name: str) -> TransmissionSettings:
        """Settings of one of `transmissions`."""
        return self.transmission_1 if name == "transmission_1" else self.transmission_2
