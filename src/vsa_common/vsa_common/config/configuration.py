# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Configuration as frozen dataclasses whose fields carry unit, range and meaning.

One declaration defines the ROS parameters of a node (`vsa_common.ros.node`), the `--config` file of a
tool, the error text of a bad value, and the tables of docs/reference/interfaces.md:

>>> @dataclass(frozen=True)
... class Sensor:
...     noise_std: float = quantity(0.017, "N", 1e-6, 100.0, "white noise of the force sensor")
>>> build(Sensor, {"noise_std": -1.0})
Traceback (most recent call last):
vsa_common.config.configuration.ConfigurationError: noise_std = -1.0 N: must be within 1e-06 to 100.0 N
"""

import difflib
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, TypeVar

import yaml

Config = TypeVar("Config")

FRAME_PREFIX = "begin of each frame_id, as of robot_state_publisher: left/ in left/joint"  # of `frame_prefix`

_KINDS = {float: "a number", int: "an integer", bool: "true or false", str: "a text"}
_NUMERALS = {float: re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?"), int: re.compile(r"[-+]?\d+")}


class ConfigurationError(ValueError):
    """A parameter is unknown, of the wrong type, or out of range; the text names it."""


@dataclass(frozen=True)
class Parameter:
    """One parameter: its default, unit, range and meaning."""

    name: str
    default: Any
    text: str
    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    options: tuple[str, ...] = ()
    tunable: bool = False  # whether it can be changed while its node is active

    def check(self, value: Any) -> Any:
        """`value` in the default's type. Raises ConfigurationError for a wrong type or a value out of range."""
        value = self.convert(value)
        for number in value if isinstance(value, tuple) else (value,):
            if self.options and number not in self.options:
                raise self._error(value, f"must be one of {', '.join(self.options)}")
            is_number = isinstance(number, float | int) and not isinstance(number, bool)
            if is_number and not self.low <= number <= self.high:
                raise self._error(value, f"must be within {self.low} to {self.high}{self._unit}")
        return value

    @property
    def kind(self) -> type:
        """Type of the value; of one element where the value is a tuple."""
        sample = self.default
        if isinstance(sample, tuple):
            return type(sample[0]) if sample else str
        return type(sample)

    @property
    def _unit(self) -> str:
        return f" {self.unit}" if self.unit else ""

    def convert(self, value: Any) -> Any:
        """`value` in the default's type, a text such as 1e-3 as its number. Raises ConfigurationError otherwise."""
        if isinstance(self.default, tuple):
            if isinstance(value, str) or not hasattr(value, "__iter__"):
                raise self._error(value, f"must be a list, each {_KINDS[self.kind]}")
            return tuple(self._scalar(element) for element in value)
        return self._scalar(value)

    def _scalar(self, value: Any) -> Any:
        if isinstance(value, str) and self.kind in _NUMERALS and _NUMERALS[self.kind].fullmatch(value):
            return self.kind(value)  # YAML 1.1 reads 1e-3 as a text
        if self.kind is float and isinstance(value, int) and not isinstance(value, bool):
            return float(value)
        if type(value) is not self.kind:
            raise self._error(value, f"must be {_KINDS[self.kind]}")
        return value

    def _error(self, value: Any, expected: str) -> ConfigurationError:
        shown = list(value) if isinstance(value, tuple) else value
        return ConfigurationError(f"{self.name} = {shown!r}{self._unit}: {expected}")


def quantity(default: float, unit: str, low: float, high: float, text: str, tunable: bool = False) -> Any:
    """A number with a unit and a closed range; `tunable`: it can be changed while its node is active."""
    return field(default=default, metadata={"unit": unit, "low": low, "high": high, "text": text, "tunable": tunable})


def quantities(default: tuple[float, ...], unit: str, low: float, high: float, text: str, tunable: bool = False) -> Any:
    """A list of numbers that share a unit and a range; the default has at least one."""
    return quantity(default, unit, low, high, text, tunable)  # type: ignore[arg-type]


def choice(default: str, options: tuple[str, ...], text: str) -> Any:
    """One of several words."""
    return field(default=default, metadata={"options": options, "text": text})


def flag(default: bool, text: str) -> Any:
    """True or false."""
    return field(default=default, metadata={"text": text})


def string(default: str | tuple[str, ...], text: str, tunable: bool = False) -> Any:
    """A text, or a list of texts."""
    return field(default=default, metadata={"text": text, "tunable": tunable})


def group(config_class: type) -> Any:
    """A dataclass within a dataclass; the names of its parameters begin with `name.`."""
    return field(default_factory=config_class)


def parameters(config_class: type, prefix: str = "") -> Iterator[Parameter]:
    """All parameters of a configuration class; names within groups are joined with dots."""
    for item in fields(config_class):
        name = prefix + item.name
        if item.default is MISSING and is_dataclass(item.default_factory):
            yield from parameters(item.default_factory, name + ".")  # type: ignore[arg-type]
        else:
            yield Parameter(name, item.default, **item.metadata)


def build(config_class: type[Config], values: Mapping[str, Any]) -> Config:
    """Configuration from flat `values` ("initial.k2": 267.2); absent parameters keep their defaults.

    Raises ConfigurationError naming the parameter, the value and the unit.
    """
    declared = {parameter.name: parameter for parameter in parameters(config_class)}
    for name in values:
        if name not in declared:
            near = difflib.get_close_matches(name, declared, n=1)
            hint = f"; did you mean {near[0]}?" if near else ""
            raise ConfigurationError(f"{name}: no such parameter{hint}")
    checked = {name: declared[name].check(value) for name, value in values.items()}
    return _assemble(config_class, checked, "")


def _assemble(config_class: type[Config], values: Mapping[str, Any], prefix: str) -> Config:
    arguments: dict[str, Any] = {}
    for item in fields(config_class):  # type: ignore[arg-type]
        name = prefix + item.name
        if item.default is MISSING and is_dataclass(item.default_factory):
            arguments[item.name] = _assemble(item.default_factory, values, name + ".")  # type: ignore[type-var]
        elif name in values:
            arguments[item.name] = values[name]
    return config_class(**arguments)


def flatten(config: Any, prefix: str = "") -> dict[str, Any]:
    """The inverse of `build`: every parameter of a configuration with its value."""
    flat: dict[str, Any] = {}
    for item in fields(config):
        value = getattr(config, item.name)
        if is_dataclass(value):
            flat |= flatten(value, f"{prefix}{item.name}.")
        else:
            flat[prefix + item.name] = value
    return flat


_OF_A_PROCESS = re.compile(r"(autostart|use_sim_time|start_type_description_service)$|(realtime|qos_overrides)\.")


def load(path: str | Path, node: str, config_class: type[Config]) -> Config:
    """Configuration of `node` (its bare name, "estimator_1") from a ROS parameter file.

    Raises ConfigurationError naming the file if it cannot be read or is not a parameter file.
    """
    try:
        return build(config_class, node_values(path, node, config_class))
    except ConfigurationError as error:
        raise ConfigurationError(f"{path}: {node}: {error}") from error


def node_values(path: str | Path, node: str, config_class: type) -> dict[str, Any]:
    """Values of a ROS parameter file for `node`, flat ("initial.k2"), unchecked.

    Keys as ROS 2 reads them: `node`, `/name/space/node`, `/**/node`, and `/**` for all nodes; a later key wins.
    Skipped are parameters of the process (`autostart`, `realtime.*`, ROS's own), and those of other nodes under `/**`.
    Raises ConfigurationError for a file with `node` in several namespaces.
    """
    from vsa_common.config.sections import sections_of, shared_names  # they are built on this module

    found = sections_of(path, node)
    values = {name: value for section in found.values() for name, value in section.items()}
    values = {name: value for name, value in values.items() if not _OF_A_PROCESS.match(name)}
    declared, shared = {parameter.name for parameter in parameters(config_class)}, shared_names(found)
    return {name: value for name, value in values.items() if name in declared or name not in shared}


def parameter_files(arguments: Sequence[str]) -> list[str]:
    """Every `--params-file` among the arguments of a ROS node."""
    return [path for option, path in pairwise(arguments) if option == "--params-file"]


def read_parameter_file(path: str | Path) -> dict[str, Any]:
    """The sections of a ROS parameter file. Raises ConfigurationError naming the file if it is not one."""
    try:
        tree = yaml.safe_load(Path(path).read_text())
    except OSError as error:
        raise ConfigurationError(f"{path}: {error.strerror}") from error
    except (UnicodeDecodeError, yaml.YAMLError) as error:
        raise ConfigurationError(f"{path}: {' '.join(str(error).split())}") from error
    if not isinstance(tree, dict):
        raise ConfigurationError(f"{path}: expected a ROS parameter file, 'node: ros__parameters: ...'")
    return tree


def flat(tree: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Parameters of a section by name: `bus.channel` for a channel within a bus."""
    values: dict[str, Any] = {}
    for name, value in tree.items():
        if isinstance(value, Mapping):
            values |= flat(value, f"{prefix}{name}.")
        else:
            values[f"{prefix}{name}"] = value
    return values
