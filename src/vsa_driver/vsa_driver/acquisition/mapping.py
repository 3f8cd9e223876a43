# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Parameters to DBC: which message carries which of the signals that are read together."""

import sys
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

from vsa_common.config.configuration import ConfigurationError
from vsa_driver.can.frames import RIG_DBC, FrameError, FrameSet, Message, Signal, Values

_PACKAGE = "package://"
_RIG = "package://vsa_driver/config/vsa_rig.dbc"


@dataclass(frozen=True)
class Source:
    """One message, and those of its signals that are read together; `roles` is the use of each signal."""

    message: Message
    roles: tuple[str, ...]
    signals: tuple[Signal, ...]
    read: Callable[[bytes], Values]

    @property
    def limits(self) -> tuple[tuple[float, float], ...]:
        """Range of each signal in the DBC; all finite numbers where the DBC has none."""
        return tuple(
            (_default(s.minimum, -sys.float_info.max), _default(s.maximum, sys.float_info.max)) for s in self.signals
        )

    def signal(self, role: str) -> Signal:
        """The signal with the role `role`."""
        return self.signals[self.roles.index(role)]


def load_frames(dbc: str) -> FrameSet:
    """The DBC at a path, or at package://package/path. Raises ConfigurationError."""
    try:
        return FrameSet(_resolve(dbc))
    except FrameError as error:
        raise ConfigurationError(f"dbc = {dbc!r}: {error}") from error


def sources(
    frames: FrameSet, requested: Mapping[str, tuple[str, str]], required: Collection[str] = ()
) -> tuple[Source, ...]:
    """The messages that carry `requested`, {role: (parameter, "message.signal")}, each with its roles in that order.

    An empty "message.signal" is left out, unless its role is `required`.
    Raises ConfigurationError naming the parameter whose signal does not exist.
    """
    by_message: dict[str, list[str]] = {}
    for role, (parameter, name) in requested.items():
        if name or role in required:
            by_message.setdefault(_split(parameter, name)[0], []).append(role)
    return tuple(_source(frames, requested, name, tuple(roles)) for name, roles in by_message.items())


def _source(frames: FrameSet, requested: Mapping[str, tuple[str, str]], name: str, roles: tuple[str, ...]) -> Source:
    signals = []
    for role in roles:
        parameter, reference = requested[role]
        try:
            message = frames.message(name)
            signals.append(message.signal(_split(parameter, reference)[1]))
        except FrameError as error:
            raise ConfigurationError(f"{parameter} = {reference!r}: {error}") from error
    return Source(message, roles, tuple(signals), message.reader(*(signal.name for signal in signals)))


def _split(parameter: str, reference: str) -> tuple[str, str]:
    message, dot, signal = reference.partition(".")
    if not (message and dot and signal):
        raise ConfigurationError(f"{parameter} = {reference!r}: must be Message.Signal")
    return message, signal


def _resolve(dbc: str) -> Path:
    if dbc == _RIG:
        return RIG_DBC
    if not dbc.startswith(_PACKAGE):
        return Path(dbc)
    from ament_index_python.packages import PackageNotFoundError, get_package_share_directory

    package, _, path = dbc.removeprefix(_PACKAGE).partition("/")
    try:
        return Path(get_package_share_directory(package)) / path
    except (PackageNotFoundError, ValueError) as error:
        raise ConfigurationError(f"dbc = {dbc!r}: no package {package!r}") from error


def _default(limit: float | None, default: float) -> float:
    return default if limit is None else float(limit)
