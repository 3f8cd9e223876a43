"""The one door to cantools: a DBC file says what the bytes of a frame mean."""

import difflib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cantools
from cantools.database.can import Message as CanMessage
from cantools.database.can import Signal as CanSignal

Values = tuple[int | float, ...]

_EXACT = 52  # bits of a count that a float holds


def _installed(name: str) -> Path:
    beside = Path(__file__).resolve().parents[2] / "config" / name  # source tree and symlink install
    if beside.exists():
        return beside
    from ament_index_python import get_package_share_directory

    return Path(get_package_share_directory("vsa_driver")) / "config" / name


RIG_DBC = _installed("vsa_rig.dbc")


class FrameError(ValueError):
    """A DBC file, message or signal that is not there, or bytes that do not fit; the text names it."""


@dataclass(frozen=True)
class Signal:
    """What a DBC file says of one signal."""

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
        plain = not message.is_multiplexed() and all(_is_plain(s) and s.length <= _EXACT for s in message.signals)
        self._places = [_place(signal) for signal in message.signals] if plain else []

    def signal(self, name: str) -> Signal:
        """Description of a signal. Raises FrameError where there is none of that name."""
        found = self._signal(name)
        return Signal(name, found.unit or "", found.length, found.minimum, found.maximum, float(found.scale))

    def encode(self, values: Mapping[str, float]) -> bytes:
        """Bytes of the frame from values in the DBC's units. Raises FrameError for one missing or out of range."""
        if (data := self._quickly(values)) is not None:
            return data
        try:
            return self._message.encode(dict(values), strict=True)
        except (cantools.database.Error, KeyError, ValueError, OverflowError, TypeError) as error:
            raise FrameError(f"{self.name}: {' '.join(str(error).split())}") from error

    def _quickly(self, values: Mapping[str, float]) -> bytes | None:
        """The same bytes a fifth of the time, for what `_plain_reader` reads; None for what cantools has to judge."""
        word = 0
        for name, start, mask, scale, offset, low, high in self._places:
            value = values.get(name)
            if value is None or not low <= value <= high:
                return None
            word |= (round((value - offset) / scale) & mask) << start
        return word.to_bytes(self.length, "little") if 0 < len(values) == len(self._places) else None

    def decode(self, data: bytes) -> dict[str, float]:
        """Values of all signals in the DBC's units. Raises FrameError for a wrong length."""
        if len(data) != self.length:
            raise FrameError(f"{self.name}: {len(data)} bytes, expected {self.length}")
        try:
            return self._message.decode(data, decode_choices=False)  # type: ignore[return-value]
        except (cantools.database.Error, KeyError) as error:  # a multiplexer that names no page
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
        """The same by shifting one integer, a third of the time, for little-endian signals without choices of pages."""
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


def _place(signal: CanSignal) -> tuple[str, int, int, float, float, float, float]:
    """Name, first bit, mask, scale and offset of a plain signal, and the values that surely fit."""
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
        """The message of that name. Raises FrameError where there is none."""
        if name not in self._messages:
            raise FrameError(f"DBC {self.path} has no message {name!r}{_hint(name, self._messages)}")
        return self._messages[name]


def _hint(name: str, known: Iterable[str]) -> str:
    near = difflib.get_close_matches(name, list(known), n=1)
    return f"; did you mean {near[0]}?" if near else ""
