# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import pytest
from vsa_driver.settings import DriverSettings, JointSettings, MotorSettings, TransmissionSettings

# Force and encoder in two messages, a 29-bit identifier, Motorola byte order, no counters, no motors.
OTHER_DAQ = """VERSION ""
BU_: Daq
BO_ 2566848894 Forces: 8 Daq
 SG_ Left : 7|16@0- (0.01,0) [-300|300] "N" Daq
 SG_ Right : 23|16@0- (0.01,0) [-300|300] "N" Daq
BO_ 32 Positions: 8 Daq
 SG_ Left : 0|32@1- (0.001,0) [-50|50] "mm" Daq
 SG_ Right : 32|32@1- (0.001,0) [-50|50] "mm" Daq
"""


@pytest.fixture
def other_daq(tmp_path):
    """Settings of a data acquisition that differs from the simulated rig's in every respect."""
    dbc = tmp_path / "daq.dbc"
    dbc.write_text(OTHER_DAQ)

    def side(name):
        return TransmissionSettings(
            force_signal=f"Forces.{name}", encoder_signal=f"Positions.{name}", counter_signal="", encoder_scale=1e-3
        )

    motors = MotorSettings(
        position_signals=("",), holding_signal="", counter_signal="", command_signals=("",), command_counter_signal=""
    )
    joint = JointSettings(angle_signal="", torque_signal="", counter_signal="")
    return replace(
        DriverSettings(),
        dbc=str(dbc),
        transmission_1=side("Left"),
        transmission_2=side("Right"),
        joint=joint,
        motors=motors,
    )
