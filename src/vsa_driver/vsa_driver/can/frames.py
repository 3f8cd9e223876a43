# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The only module that imports cantools: bytes of a frame to values and back, as a DBC file defines them."""

import difflib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cantools
from cantools.database.can import Message as CanMessage
from cantools.database.can import Signal as CanSignal

Values = tuple[int | float, ...]

_EXACT_BITS = 52  # a float represents a count of this width exactly


def _installed(name: str) -> Path:
    in_tree = Path(__file__).resolve().parents[2] / "config" / name  # source tree and symlink install
    if in_tree.exists():
        return in_tree
    from ament_index_python import get_package_share_directory

    return Path(get_package_share_directory("vsa_driver")) / "config" / name


RIG_DBC = _installed("vsa_rig.dbc")


class FrameError(ValueError):
    """A DBC file, message or signal does not exist, or bytes or values are invalid; the text names it."""


@dataclass(frozen=True)
class Signal:
    """Definition of one signal in a DBC file."""

    name: str
    unit: str
    bits: int
    minimum: float | None
    maximum: float | None
    step: float  # value of one count


class Message:
    """One message of a DBC file: bytes to values and back."""

    def __init__(self, message: CanMessage) -> None:
        self._message = message
        self.name = message.name
        self.id = message.frame_id
        self.extended = message.is_extended_frame
        self.fd = message.is_fd
        self.length = message.length
        plain = not message.is_multiplexed() and all(_is_plain(s) and s.length <= _EXACT_BITS for s in message.signals)
        self._layout = [_layout(signal) for signal in message.signals] if plain else []

    def signal(self, name: str) -> Signal:
        """Definition of a signal. Raises FrameError where the message has none of that name."""
        one = self._signal(name)
        return Signal(name, one.unit or "", one.length, one.minimum, one.maximum, float(one.scale))

    def encode(self, values: Mapping[str, float]) -> bytes:
        """Bytes of the frame from values in the DBC's units. Raises FrameError for one missing or out of range."""
        if (data := self._encode_fast(values)) is not None:
            return data
        try:
            return self._message.encode(dict(values), strict=True)
        except (cantools.database.Error, KeyError, ValueError, OverflowError, TypeError) as error:
            raise FrameError(f"{self.name}: {' '.join(str(error).split())}") from error

    def _encode_fast(self, values: Mapping[str, float]) -> bytes | None:
        """The bytes in a fifth of the time of cantools, for plain signals in their range; None for all others."""
        word = 0
        for name, start, mask, scale, offset, low, high in self._layout:
            value = values.get(name)
            if value is None or not low <= value <= high:
                return None
            word |= (round((value - offset) / scale) & mask) << start
        return word.to_bytes(self.length, "little") if 0 < len(values) == len(self._layout) else None

    def decode(self, data: bytes) -> dict[str, float]:
        """Values of all signals in the DBC's units. Raises FrameError for a wrong length."""
        if len(data) != self.length:
            raise FrameError(f"{self.name}: {len(data)} bytes, expected {self.length}")
        try:
            return self._message.decode(data, decode_choices=False)  # type: ignore[return-value]
        except (cantools.database.Error, KeyError) as error:  # a multiplexer value without a page
            raise FrameError(f"{self.name}: {' '.join(str(error).split())}") from error

    def reader(self, *names: str) -> Callable[[bytes], Values]:
        """A function from a frame's bytes to the values of the named signals, in that order.

        It raises FrameError for a wrong length, and where a multiplexed frame does not carry the signal.
        """
        signals = [self._signal(name) for name in names]
        if not self._message.is_multiplexed() and all(map(_is_plain, signals)):
            return self._plain_reader(signals)

        def read(data: bytes) -> Values:
            values = self.decode(data)
            try:
                return tuple([values[name] for name in names])
            except KeyError as error:
                raise FrameError(f"{self.name}: frame without signal {error}") from error

        return read

    def _plain_reader(self, signals: Sequence[CanSignal]) -> Callable[[bytes], Values]:
        """Reads little-endian signals by shifts of one integer, in a third of the time of cantools."""
        fields = [(s.start, (1 << s.length) - 1, _sign(s), s.scale, s.offset) for s in signals]

        def read(data: bytes) -> Values:
            if len(data) != self.length:
                raise FrameError(f"{self.name}: {len(data)} bytes, expected {self.length}")
            word = int.from_bytes(data, "little")
            return tuple(
                [
                    (((word >> start & mask) ^ sign) - sign) * scale + offset
                    for start, mask, sign, scale, offset in fields
                ]
            )

        return read

    def _signal(self, name: str) -> CanSignal:
        names = [signal.name for signal in self._message.signals]
        if name not in names:
            raise FrameError(f"message {self.name} has no signal {name!r}{_hint(name, names)}")
        return self._message.get_signal_by_name(name)


def _is_plain(signal: CanSignal) -> bool:
    return signal.byte_order == "little_endian" and not signal.is_float


def _sign(signal: CanSignal) -> int:
    return 1 << (signal.length - 1) if signal.is_signed else 0


def _layout(signal: CanSignal) -> tuple[str, int, int, float, float, float, float]:
    """Name, first bit, mask, scale and offset of a plain signal, and the range of its values."""
    sign, mask = _sign(signal), (1 << signal.length) - 1
    ends = sorted(raw * signal.scale + signal.offset for raw in (-sign, mask - sign))
    low = ends[0] if signal.minimum is None else max(ends[0], signal.minimum)
    high = ends[1] if signal.maximum is None else min(ends[1], signal.maximum)
    return signal.name, signal.start, mask, signal.scale, signal.offset, low, high


class FrameSet:
    """All messages of a DBC file.

    >>> FrameSet(RIG_DBC).message("Transmission1").signal("Force").unit
    'N'
    """

    def __init__(self, path: str | Path) -> None:
        try:
            database = cantools.database.load_file(path)
        except (OSError, ValueError, KeyError, cantools.database.Error) as error:
            raise FrameError(f"cannot read DBC {path}: {' '.join(str(error).split())}") from error
        if not isinstance(database, cantools.database.can.Database):
            raise FrameError(f"cannot read DBC {path}: it describes no CAN messages")
        self.path = Path(path)
        self._messages = {message.name: Message(message) for message in database.messages}

    def message(self, name: str) -> Message:
        """The message of that name. Raises FrameError where the file has none."""
        if name not in self._messages:
            raise FrameError(f"DBC {self.path} has no message {name!r}{_hint(name, self._messages)}")
        return self._messages[name]


def _hint(name: str, names: Iterable[str]) -> str:
    near = difflib.get_close_matches(name, list(names), n=1)
    return f"; did you mean {near[0]}?" if near else ""
