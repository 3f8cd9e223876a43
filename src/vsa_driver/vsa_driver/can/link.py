# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""A CAN bus that is read by a thread of its own or step by step, and reopened after a failure."""

import threading
import time
from collections.abc import Callable

from vsa_common.ros.idle import Coalescer
from vsa_driver.can.bus import Bus, BusConfig, BusError, Frame, MalformedFrame, open_bus
from vsa_driver.tuning import BACKOFF_S, IDLE_PERIOD_S, POLL_S

_BUS_OFF = 0x40  # CAN_ERR_BUSOFF of <linux/can/error.h>, in the identifier of an error frame


class BusLink:
    """Passes every frame to `on_frame` and the reason of a failure to `on_down`, from a thread or from `step`.

    `on_idle`, where given, gets the instant of the monotonic clock [ns] until which no frame has arrived.
    A busy thread waits for `coalescing_s` [s] between reads, so that frames are read in batches.
    """

    def __init__(
        self,
        config: BusConfig,
        on_frame: Callable[[Frame], None],
        on_down: Callable[[str], None],
        opener: Callable[[BusConfig], Bus] = open_bus,
        on_idle: Callable[[int], None] | None = None,
        coalescing_s: float = 0.0,
    ) -> None:
        self.malformed = 0  # datagrams that were no frames
        self.failures = 0
        self.reopened = 0
        self.reason = ""  # why the bus is down; empty while it is up
        self.last_reason = ""  # of the last failure
        self._config = config
        self._on_frame = on_frame
        self._on_down = on_down
        self._on_idle = on_idle
        self._opener = opener
        self._bus: Bus | None = None
        self._backoff_s, self._retry_s = BACKOFF_S[0], 0.0
        self._coalescing_s = coalescing_s
        self._poll_s = POLL_S if on_idle is None else IDLE_PERIOD_S
        self._stopping = threading.Event()
        self._thread: threading.Thread | None = None

    @property
    def up(self) -> bool:
        """Whether the bus is open and being read."""
        return self._bus is not None and (self._thread is None or self._thread.is_alive())

    @property
    def single_threaded(self) -> bool:
        """Whether the link has no thread and the caller has to call `step`."""
        return self._thread is None

    def open(self, single_threaded: bool = False) -> None:
        """Open the bus and read it; `single_threaded` without a thread where the interface has a file descriptor.

        Raises BusError where the bus cannot be opened the first time.
        """
        self._bus = self._opener(self._config)
        if not single_threaded or self._bus.fileno() < 0:
            self._thread = threading.Thread(target=self._read, name="can", daemon=True)
            self._thread.start()

    def fileno(self) -> int:
        """File descriptor to wait on before `step`; -1 while the bus is down."""
        return -1 if self._bus is None else self._bus.fileno()

    def close(self) -> None:
        """Stop the thread, wait for it, and close the bus."""
        self._stopping.set()
        if self._thread is not None:
            self._thread.join()
        self._close_bus()

    def send(self, arbitration_id: int, data: bytes, extended: bool, fd: bool) -> None:
        """Send one frame. Raises BusError while the bus is down."""
        bus = self._bus
        if bus is None:
            raise BusError(self.reason)
        bus.send(arbitration_id, data, extended, fd)

    def step(self, timeout: float) -> bool:
        """Read one frame, waiting at most `timeout` [s], or reopen the bus; whether there may be more to read."""
        begin = time.monotonic()
        if self._bus is None:
            self._reopen(begin, timeout)
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
            self._report_idle(begin + timeout)
            return False
        self._backoff_s = BACKOFF_S[0]
        self._on_frame(frame)
        return True

    def _read(self) -> None:
        coalescer = Coalescer(self._coalescing_s)
        while not self._stopping.is_set():
            self.step(self._poll_s)
            if (pause_s := coalescer.pause()) > 0.0:
                while self.step(0.0) and not self._stopping.is_set():
                    pass
                self._stopping.wait(pause_s)

    def _reopen(self, now: float, timeout: float) -> None:
        if now < self._retry_s:
            self._stopping.wait(min(timeout, self._retry_s - now))
            self._report_idle(now)
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
        self._retry_s = now + self._backoff_s
        self._backoff_s = min(2 * self._backoff_s, BACKOFF_S[1])

    def _report_idle(self, until: float) -> None:
        """Report that no frame arrived until the instant `until` [s]; later frames have not been read yet."""
        if self._on_idle is not None:
            self._on_idle(int(until * 1e9))

    def _fail(self, reason: str) -> None:
        self.failures += 1
        self.reason = self.last_reason = reason
        self._close_bus()
        self._back_off(time.monotonic())
        self._on_down(reason)

    def _close_bus(self) -> None:
        bus, self._bus = self._bus, None
        if bus is not None:
            bus.close()
