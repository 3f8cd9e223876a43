# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Options of the demo that change the force laws and sensors of the simulated rig.

Each is one parameter of the node rig_simulator; help, range and choices are those of its declaration.
"""

import argparse
from collections.abc import Callable
from typing import Any

from vsa_common.config.configuration import ConfigurationError, Parameter, parameters
from vsa_estimator.settings import EstimatorConfig
from vsa_simulator.rig.config import RigConfig

OPTIONS = {  # option: placeholder, parameter, example
    "spring": ("NAME", "spring.kind", "sinh is the form of the qbmove, stop a spring whose coils close"),
    "spring-drift": ("PERCENT", "spring.drift", "1 is slow, 10 fast"),
    "damper": ("NAME", "damper.kind", "soft_knee approaches a greatest force, quadratic is flow through an orifice"),
    "friction": ("NAME", "friction.model", "stribeck is lubricated contact"),
    "viscoelastic": ("SHARE", "viscoelastic.share", "0.2 relaxes as a soft polymer"),
    "hysteresis": ("N", "hysteresis.amplitude", "0.6 is twice the rig's Coulomb friction"),
    "sensor-delay": ("S", "sensor_errors.force_delay", "0.005 is half a sample at 100 Hz"),
    "force-lowpass": ("HZ", "sensor_errors.force_lowpass", "20 is a common filter of load cells"),
    "force-hysteresis": ("N", "sensor_errors.force_hysteresis", "0.1 is 0.05 % of the full scale of 200 N"),
    "force-drift": ("N", "sensor_errors.force_drift", "0.2 a minute, as while a load cell warms up"),
    "crosstalk": ("SHARE", "sensor_errors.crosstalk", "0.02 for two sensors on one frame"),
    "encoder-cyclic": ("M", "sensor_errors.encoder_cyclic", "5e-6 is half a count of the encoder"),
    "stamp-jitter": ("S", "sensor_errors.frame_jitter", "0.001 as of a busy computer; less than the time of a sample"),
}
TITLE = "other transmissions and sensors"
TEXT = """By default the rig obeys the paper's laws, and its sensors have noise and resolution only. These options act
on both transmissions; docs/reference/parameters.md has all parameters of the rig. With another spring or damper the
table lists stiffness and damping at the end of the run in place of k2 and d2. True stiffness is the slope of the static
spring, without relaxation and hysteresis; true damping is the slope of the damper, without friction."""


def add_rig_options(parser: argparse.ArgumentParser) -> None:
    """Add all options to `parser`; an option that is absent keeps the rig's parameter."""
    declared = {parameter.name: parameter for parameter in parameters(RigConfig)}
    group = parser.add_argument_group(TITLE, TEXT)
    for option, (placeholder, name, example) in OPTIONS.items():
        parameter = declared[name]
        help_text = f"{_description(parameter)}; {example}".replace("%", "%%")
        group.add_argument(f"--{option}", type=reader_of(name), metavar=placeholder, help=help_text)
    law = next(one for one in parameters(EstimatorConfig) if one.name == "elastic_law")
    group.add_argument("--elastic-law", choices=law.options, help=law.text)


def rig_changes(options: argparse.Namespace) -> dict[str, dict[str, Any]]:
    """Parameters of the rig by the given options; groups are nested."""
    changes: dict[str, dict[str, Any]] = {}
    for option, (_, name, _) in OPTIONS.items():
        value = getattr(options, option.replace("-", "_"), None)
        if value is not None:
            section, _, leaf = name.partition(".")
            changes.setdefault(section, {})[leaf] = value
    return changes


def estimator_changes(options: argparse.Namespace) -> dict[str, dict[str, Any]]:
    """Parameters of both estimators by the given options."""
    law = getattr(options, "elastic_law", None)
    return {f"estimator_{i}": {"elastic_law": law} for i in (1, 2)} if law else {}


def reader_of(name: str) -> Callable[[str], Any]:
    """Text of an option to the value of the rig's parameter `name`; the error of a bad value lists choices or range."""
    parameter = next(one for one in parameters(RigConfig) if one.name == name)

    def read(text: str) -> Any:
        try:
            return parameter.check(text if parameter.options else parameter.kind(text))
        except ConfigurationError as error:
            raise argparse.ArgumentTypeError(str(error)) from error
        except ValueError as error:
            raise argparse.ArgumentTypeError(f"{text!r} is not a number [{parameter.unit or '1'}]") from error

    return read


def _description(parameter: Parameter) -> str:
    if parameter.options:
        return f"{parameter.text}; one of {', '.join(parameter.options)} ({parameter.default})"
    limits = f"{parameter.low:g} to {parameter.high:g} {parameter.unit}".strip()
    return f"{parameter.text}; {limits} ({parameter.default:g})"
