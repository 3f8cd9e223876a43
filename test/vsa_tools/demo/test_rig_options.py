# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Options for other transmissions and sensors: to the rig's parameters, errors that list what is permitted."""

import argparse

import pytest
from vsa_common.config.configuration import load
from vsa_estimator.settings import NodeConfig
from vsa_simulator.node import SimulatorConfig
from vsa_tools.demo.command import write_run
from vsa_tools.demo.rig_options import OPTIONS, add_rig_options, rig_changes

GIVEN = (
    "--spring sinh --spring-drift 1 --damper soft_knee --friction stribeck --viscoelastic 0.2 --hysteresis 0.6 "
    "--sensor-delay 0.005 --force-lowpass 20 --force-hysteresis 0.1 --force-drift 0.2 --crosstalk 0.02 "
    "--encoder-cyclic 2e-5 --stamp-jitter 0.001"
)


def parsed(text, **further):
    parser = argparse.ArgumentParser()
    add_rig_options(parser)
    return argparse.Namespace(**vars(parser.parse_args(text.split())), **further)


def test_every_option_sets_its_parameter_of_the_rig(tmp_path):
    options = parsed(GIVEN, duration=12.0, rate=250, seed=3, out=tmp_path)
    rig = load(write_run(tmp_path, options, 61_234, {}), "rig_simulator", SimulatorConfig)
    assert len(GIVEN.split()) == 2 * len(OPTIONS)
    assert (rig.spring.kind, rig.spring.drift, rig.damper.kind, rig.friction.model) == (
        "sinh",
        1,
        "soft_knee",
        "stribeck",
    )
    assert (rig.viscoelastic.share, rig.hysteresis.amplitude) == (0.2, 0.6)
    errors = rig.sensor_errors
    assert (errors.force_delay, errors.force_lowpass, errors.force_hysteresis) == (0.005, 20.0, 0.1)
    assert (errors.force_drift, errors.crosstalk, errors.encoder_cyclic) == (0.2, 0.02, 2e-5)
    assert errors.frame_jitter == 0.001
    assert rig.transmission_1.k2 == 267.2


def test_absent_options_change_nothing():
    assert rig_changes(parsed("")) == {}
    assert rig_changes(parsed("--damper linear")) == {"damper": {"kind": "linear"}}


@pytest.mark.parametrize(
    ("text", "law"),
    [
        ("", "automatic"),
        ("--spring sinh", "automatic"),
        ("--spring sinh --elastic-law exponential", "exponential"),
        ("--elastic-law automatic", "automatic"),
    ],
)
def test_the_estimators_assume_no_law_unless_one_is_given(text, law, tmp_path):
    options = parsed(text, duration=12.0, rate=250, seed=3, out=tmp_path)
    file = write_run(tmp_path, options, 61_234, {})
    assert [load(file, f"estimator_{i}", NodeConfig).elastic_law for i in (1, 2)] == [law, law]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("--spring rubber", "must be one of exponential, linear, quadratic, cubic, sinh, stop, softening, tabulated"),
        ("--damper oil", "must be one of cubic, linear, quadratic, soft_knee"),
        ("--friction none", "must be one of tanh, stribeck, lugre"),
        ("--sensor-delay 5", "sensor_errors.force_delay = 5.0 s: must be within 0.0 to 1.0 s"),
        ("--hysteresis much", "'much' is not a number [N]"),
    ],
)
def test_a_bad_value_is_refused_with_the_permitted_ones(text, reason, capsys):
    with pytest.raises(SystemExit):
        parsed(text)
    assert reason in capsys.readouterr().err


def test_the_help_has_choices_range_default_and_example_of_each_option(capsys):
    with pytest.raises(SystemExit):
        parsed("--help")
    text = " ".join(capsys.readouterr().out.split())
    for words in ("softening, tabulated (exponential)", "0 to 1 s (0); 0.005 is", "-100 to 100 %/min (0)"):
        assert words in text
