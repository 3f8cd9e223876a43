"""A CAN bus that is read, by a thread of its own or step by step, and opened again when it fails."""

import threading
import time
from collections.abc import Callable

from vsa_common.ros.idle import Coalescer
from vsa_driver.can.bus import Bus, BusConfig, BusError, Frame, MalformedFrame, open_bus

BACKOFF_S = (0.05, 1.0)  # first and longest wait before the bus is opened again
_BUS_OFF = 0x40  # CAN_ERR_BUSOFF of <linux/can/error.h>, in the identifier of an error frame
_POLL_S = 0.1  # how long a stop may take
_QUIET_S = 0.005  # how often a listener is told that nothing has come


class BusLink:
    """Hands every frame to `on_frame` and tells `on_down` of a failure, from a thread of its own, or from `step`.

    The thread rests for `rest` [s] between turns while it is busy.
    And `on_quiet`, where it is given, of the instant of the steady clock [ns] until which nothing has come.
    """

    def __init__(
        self,
        config: BusConfig,
        on_frame: Callable[[Frame], None],
        on_down: Callable[[str], None],
        opener: Callable[[BusConfig], Bus] = open_bus,
        on_quiet: Callable[[int], None] | None = None,
        rest: float = 0.0,
    ) -> None:
        self.malformed = 0  # datagrams that were no frames
        self.failures = 0
        self.reopened = 0
        self.reason = ""  # why the bus is down; empty while it is up
        self.last_reason = ""  # why it was down the last time
        self._config = config
        self._on_frame = on_frame
        self._on_down = on_down
        self._on_quiet = on_quiet
        self._opener = opener
        self._bus: Bus | None = None
        self._wait_s, self._again = BACKOFF_S[0], 0.0
        self._rest_s = rest
        self._poll_s = _POLL_S if on_quiet is None else _QUIET_S
        self._stopping = threading.Event()
        self._thread: threading.Thread | None = None

    @property
    def up(self) -> bool:
        """Whether the bus is open and being read."""
        return self._bus is not None and (self._thread is None or self._thread.is_alive())

    @property
    def polled(self) -> bool:
        """Whether there is no thread, and `step` has to be called."""
        return self._thread is None

    def open(self, polled: bool = False) -> None:
        """Open the bus and begin to read, with `polled` without a thread where the interface can be waited for.

        Raises BusError where it cannot be opened the first time.
        """
        self._bus = self._opener(self._config)
        if not polled or self._bus.fileno() < 0:
            self._thread = threading.Thread(target=self._read, name="can", daemon=True)
            self._thread.start()

    def fileno(self) -> int:
        """What to wait for before `step`; -1 while the bus is down."""
        return -1 if self._bus is None else self._bus.fileno()

    def close(self) -> None:
        """Stop the thread, wait for it, and close the bus."""
        self._stopping.set()
        if self._thread is not None:
            self._thread.join()
        self._drop()

    def send(self, arbitration_id: int, data: bytes, extended: bool, fd: bool) -> None:
        """Send one frame. Raises BusError while the bus is down."""
        bus = self._bus
        if bus is None:
            raise BusError(self.reason)
        bus.send(arbitration_id, data, extended, fd)

    def step(self, timeout: float) -> bool:
        """Take one frame, waiting for it so long [s], or mend the bus; whether there was one."""
        begin = time.monotonic()
        if self._bus is None:
            self._mend(begin, timeout)
            return False
        frame = None
        try:
            frame = self._bus.receive(timeout)
            if frame is not None and frame.is_error_frame and frame.arbitration_id & _BUS_OFF:
                raise BusError(f"{self._bus.name}: bus-off")
        except MalformedFrame:
            self.malformed += 1
            return True
        except BusError as error:
            self._fail(str(error))
            return True
        if frame is None:
            self._quiet(begin + timeout)
            return False
        self._wait_s = BACKOFF_S[0]
        self._on_frame(frame)
        return True

    def _read(self) -> None:
        rest = Coalescer(self._rest_s)
        while not self._stopping.is_set():
            self.step(self._poll_s)
            if (seconds := rest.pause()) > 0.0:
                while self.step(0.0) and not self._stopping.is_set():
                    pass
                self._stopping.wait(seconds)

    def _mend(self, now: float, timeout: float) -> None:
        if now < self._again:
            self._stopping.wait(min(timeout, self._again - now))
            self._quiet(now)
            return
        try:
            self._bus = self._opener(self._config)
        except BusError as error:
            self.reason = str(error)
            self._back_off(now)
        else:
            self.reason = ""
            self.reopened += 1

    def _back_off(self, now: float) -> None:
        self._again = now + self._wait_s
        self._wait_s = min(2 * self._wait_s, BACKOFF_S[1])

    def _quiet(self, until: float) -> None:
        """However late we are: nothing has come until then [s]. What came later has not been looked for yet."""
        if self._on_quiet is not None:
            self._on_quiet(int(until * 1e9))

    def _fail(self, reason: str) -> None:
        self.failures += 1
        self.reason = self.last_reason = reason
        self._drop()
        self._back_off(time.monotonic())
        self._on_down(reason)

    def _drop(self) -> None:
        bus, self._bus = self._bus, None
        if bus is not None:
            bus.close()
