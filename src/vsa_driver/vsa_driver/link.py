"""A CAN bus that a thread of its own reads, and that is opened again when it fails."""

import threading
from collections.abc import Callable

from vsa_driver.bus import Bus, BusConfig, BusError, Frame, MalformedFrame, open_bus

BACKOFF_S = (0.05, 1.0)  # first and longest wait before the bus is opened again
_BUS_OFF = 0x40  # CAN_ERR_BUSOFF of <linux/can/error.h>, in the identifier of an error frame
_POLL_S = 0.1  # how long a stop may take


class BusLink:
    """Hands every frame to `on_frame`, from its own thread. `on_down` is told of a failure, from the same thread."""

    def __init__(
        self,
        config: BusConfig,
        on_frame: Callable[[Frame], None],
        on_down: Callable[[str], None],
        opener: Callable[[BusConfig], Bus] = open_bus,
    ) -> None:
        self.malformed = 0  # datagrams that were no frames
        self.failures = 0
        self.reopened = 0
        self.reason = ""  # why the bus is down; empty while it is up
        self.last_reason = ""  # why it was down the last time
        self._config = config
        self._on_frame = on_frame
        self._on_down = on_down
        self._opener = opener
        self._bus: Bus | None = None
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._read, name="can", daemon=True)

    @property
    def up(self) -> bool:
        """Whether the bus is open and being read."""
        return self._bus is not None and self._thread.is_alive()

    def open(self) -> None:
        """Open the bus and begin to read. Raises BusError where it cannot be opened the first time."""
        self._bus = self._opener(self._config)
        self._thread.start()

    def close(self) -> None:
        """Stop the thread, wait for it, and close the bus."""
        self._stopping.set()
        self._thread.join()
        self._drop()

    def send(self, arbitration_id: int, data: bytes, extended: bool, fd: bool) -> None:
        """Send one frame. Raises BusError while the bus is down."""
        bus = self._bus
        if bus is None:
            raise BusError(self.reason)
        bus.send(arbitration_id, data, extended, fd)

    def _read(self) -> None:
        wait_s = BACKOFF_S[0]
        while not self._stopping.is_set():
            if self._bus is None:
                self._stopping.wait(wait_s)
                wait_s = min(2 * wait_s, BACKOFF_S[1])
                self._reopen()
                continue
            try:
                frame = self._bus.receive(_POLL_S)
                if frame is not None and frame.is_error_frame and frame.arbitration_id & _BUS_OFF:
                    raise BusError(f"{self._bus.name}: bus-off")
            except MalformedFrame:
                self.malformed += 1
            except BusError as error:
                self._fail(str(error))
            else:
                if frame is not None:
                    wait_s = BACKOFF_S[0]
                    self._on_frame(frame)

    def _fail(self, reason: str) -> None:
        self.failures += 1
        self.reason = self.last_reason = reason
        self._drop()
        self._on_down(reason)

    def _reopen(self) -> None:
        try:
            self._bus = self._opener(self._config)
        except BusError as error:
            self.reason = str(error)
        else:
            self.reason = ""
            self.reopened += 1

    def _drop(self) -> None:
        bus, self._bus = self._bus, None
        if bus is not None:
            bus.close()
