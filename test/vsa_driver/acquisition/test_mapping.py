# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import pytest
from vsa_common.config.configuration import ConfigurationError
from vsa_driver.acquisition.mapping import load_frames, sources
from vsa_driver.acquisition.router import Router
from vsa_driver.can.frames import RIG_DBC
from vsa_driver.settings import DriverSettings, MotorSettings, TransmissionSettings

RIG = "package://vsa_driver/config/vsa_rig.dbc"


def error_of(settings):
    def configure():
        Router(load_frames(settings.dbc), settings)

    with pytest.raises(ConfigurationError) as caught:
        configure()
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_the_defaults_map_the_simulated_rig():
    router = Router(load_frames(RIG), DriverSettings())
    assert list(router.transmissions) == ["transmission_1", "transmission_2"]
    assert [channel.stream.roles for channel in router.joint] == [("angle", "torque", "counter")]
    assert router.motors is not None


def test_a_dbc_is_found_by_path_and_by_package():
    assert load_frames(RIG).path == RIG_DBC
    assert load_frames(str(RIG_DBC)).message("Joint").id == 0x110


def test_signals_of_one_message_are_read_together_and_an_empty_one_is_left_out():
    requested = {
        "a": ("p.a", "Joint.Angle"),
        "b": ("p.b", "Transmission1.Force"),
        "c": ("p.c", ""),
        "d": ("p.d", "Joint.RollingCounter"),
    }
    found = sources(load_frames(RIG), requested)
    assert [(source.message.name, source.roles) for source in found] == [
        ("Joint", ("a", "d")),
        ("Transmission1", ("b",)),
    ]


def test_other_data_acquisition_is_mapped_by_parameters_alone(other_daq):
    router = Router(load_frames(other_daq.dbc), other_daq)
    assert [source.message.id for source in router.transmissions["transmission_2"].stream.sources] == [0x18FF017E, 32]
    assert router.transmissions["transmission_2"].stream.sources[0].message.extended
    assert not router.joint
    assert router.motors is None


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"force_signal": "Transmission1.Forse"}, ["transmission_1.force_signal", "'Forse'", "did you mean Force?"]),
        ({"encoder_signal": "Transmision1.Force"}, ["transmission_1.encoder_signal", "did you mean Transmission1?"]),
        ({"counter_signal": "RollingCounter"}, ["transmission_1.counter_signal", "must be Message.Signal"]),
        ({"force_signal": ".Force"}, ["must be Message.Signal"]),
        ({"force_signal": ""}, ["transmission_1.force_signal", "must be Message.Signal"]),
        ({"encoder_signal": ""}, ["transmission_1.encoder_signal", "must be Message.Signal"]),
    ],
)
def test_a_missing_signal_is_named_with_its_parameter(change, words):
    text = error_of(replace(DriverSettings(), transmission_1=replace(TransmissionSettings(), **change)))
    assert all(word in text for word in words), text


def test_a_missing_or_invalid_dbc_is_named(tmp_path):
    assert "absent.dbc" in error_of(replace(DriverSettings(), dbc=str(tmp_path / "absent.dbc")))
    assert "no package" in error_of(replace(DriverSettings(), dbc="package://no_such_package/x.dbc"))
    broken = tmp_path / "broken.dbc"
    broken.write_text("BO_ nonsense")
    assert "broken.dbc" in error_of(replace(DriverSettings(), dbc=str(broken)))


@pytest.mark.parametrize(
    "signals",
    [
        ("MotorCommand.Position1", "MotorState.Position2"),
        ("MotorCommand.Nothing", "x.y"),
        ("Joint.Angle", "Joint.ExternalTorque"),
    ],
)
def test_command_signals_of_several_messages_are_refused(signals):
    assert "motors.command" in error_of(replace(DriverSettings(), motors=MotorSettings(command_signals=signals)))


@pytest.mark.parametrize("names", [("transmission_3",), ("transmission_1", "transmission_1"), ()])
def test_transmissions_are_the_two_of_a_joint_or_one_of_them(names):
    with pytest.raises(ConfigurationError, match="transmissions"):
        DriverSettings(transmissions=names)


def test_reversed_limits_are_refused():
    with pytest.raises(ConfigurationError, match="deflection_min"):
        TransmissionSettings(deflection_min=0.02, deflection_max=0.01)
    with pytest.raises(ConfigurationError, match="position_min"):
        MotorSettings(position_min=1.0, position_max=1.0)


def test_one_motor_of_two_is_refused():
    with pytest.raises(ConfigurationError, match="command_signals"):
        MotorSettings(command_signals=("MotorCommand.Position1",))
