# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The simulated rig in real time: a thread that paces it, sends its frames and receives its commands."""

import random
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence

from vsa_driver.can.bus import Bus, BusError, Frame, MalformedFrame
from vsa_driver.can.frames import FrameError
from vsa_simulator.faults.failure import Event
from vsa_simulator.faults.injection import Faults, TxFrame
from vsa_simulator.frames import RigFrames
from vsa_simulator.ground_truth import TruthFile
from vsa_simulator.pacing import Pacer
from vsa_simulator.rig.rig import Rig

_IDLE_S = 0.01  # period of reading the bus while the clock is stopped
_BURST_PAUSE_S = 0.0005  # between two bursts, so that receivers can read the bus
_MAX_FRAMES = 64  # frames read from the bus between two samples


class FrameDelays:
    """Random delays of a sample's frames, uniform up to `greatest` [s], the same for the same seed."""

    def __init__(self, greatest: float, seed: int) -> None:
        self._greatest, self._random = greatest, random.Random(seed)

    def draw(self) -> float:
        """The delay of the next sample [s]."""
        return self._random.uniform(0.0, self._greatest)

    def wait(self) -> None:
        """Wait for the delay of the next sample, if there are delays."""
        if self._greatest > 0.0:
            time.sleep(self.draw())


class RigLoop:
    """Runs `rig` on `bus` until `close`, for at most `samples` samples, and writes their ground truth to `truth`.

    `events` take effect at their times; the rig's thread calls `on_event` with each event and its sample.
    """

    def __init__(
        self,
        rig: Rig,
        bus: Bus,
        frames: RigFrames,
        slow_every: int,
        samples: int | None = None,
        truth: TruthFile | None = None,
        events: Sequence[Event] = (),
        on_event: Callable[[Event, int], None] = lambda event, sample: None,
    ) -> None:
        self.commands = 0  # frames received
        self.bad_frames = 0  # invalid command frames, datagrams that were no frames
        self.send_failures = 0
        self.reason = ""  # of the last failure to send
        self.failure = ""  # exception that ended the rig's thread
        self.faults = Faults(rig.config.rate_hz, rig.config.sensors, rig.config.seed)
        self._rig, self._bus, self._frames, self._truth = rig, bus, frames, truth
        self._slow_every = slow_every
        self._samples = samples
        self._events = deque(events)
        self._pending: deque[Event] = deque()
        self._on_event = on_event
        self._delays = FrameDelays(rig.config.sensor_errors.frame_jitter, rig.config.seed)
        self._pacer = Pacer(rig.config.rate_hz)
        self._started = threading.Event()  # set while the clock is to run
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="rig", daemon=True)

    @property
    def sent(self) -> int:
        """Number of samples sent."""
        return self._rig.sample

    @property
    def done(self) -> bool:
        """Whether the last sample was sent."""
        return self._samples is not None and self._rig.sample >= self._samples

    @property
    def running(self) -> bool:
        """Whether the rig's clock runs."""
        return self._started.is_set() and not self.done and not self.failure

    @property
    def overruns(self) -> int:
        """Samples sent after the deadline of the next one."""
        return self._pacer.overruns

    @property
    def holding(self) -> bool:
        """Whether the motors hold their position because commands have stopped."""
        return self._rig.holding

    def inject(self, event: Event) -> None:
        """Apply `event` with the next sample."""
        self._pending.append(event)

    def open(self) -> None:
        """Start the thread, with the clock stopped."""
        self._thread.start()

    def start_clock(self) -> None:
        """Start the clock at the next sample."""
        self._started.set()

    def stop_clock(self) -> None:
        """Stop the clock; the state of the rig stays."""
        self._started.clear()

    def close(self) -> None:
        """Stop the thread, wait for it, close bus and truth file; `failure` names a file that cannot be completed."""
        self._closing.set()
        self._thread.join()
        self._bus.close()
        try:
            if self._truth is not None:
                self._truth.close()
        except OSError as error:  # the disk is full
            self.failure = self.failure or _text(error)

    def _run(self) -> None:
        try:
            self._pace()
        except Exception as error:  # of the rig, its frames or the truth file: `failure` makes it known
            self.failure = _text(error)

    def _pace(self) -> None:
        while not self._closing.is_set():
            if not self.running:
                self._pacer.stop()
                self._receive_commands()
                self._closing.wait(_IDLE_S)
                continue
            if not self._pacer.running:
                self._pacer.start(time.monotonic_ns())
            for _ in range(self._pacer.take_due(time.monotonic_ns())):
                self._step()
            self._receive_commands()
            pause = self._pacer.wait(time.monotonic_ns())
            time.sleep(pause if pause > 0.0 else _BURST_PAUSE_S)

    def _step(self) -> None:
        if self.done:
            return
        self._apply_events()
        first, truth, readings = self._rig.advance(1)
        if self.faults.active:
            self.faults.expire(first)
        force_1, force_2, count_1, count_2, angle, torque = self.faults.readings(readings, first)
        one = self._frames.transmission(0, first, force_1, int(count_1))
        two = self._frames.transmission(1, first, force_2, int(count_2))
        self._delays.wait()
        self._send(one, 1)  # both are encoded before the first is sent: they are of one instant
        self._send(two, 2)
        sequence, remainder = divmod(first, self._slow_every)
        if remainder == 0:
            self._send(self._frames.joint(sequence, angle, torque))
            motor_1, motor_2 = readings.motors[0].tolist()
            self._send(self._frames.motors(sequence, (motor_1, motor_2), self._rig.holding))
        if self._truth is not None:
            self._truth.write(first, truth[0].tolist())

    def _apply_events(self) -> None:
        while self._events and self._events[0].at <= self._rig.time:
            self._pending.append(self._events.popleft())
        while self._pending:
            event = self._pending.popleft()
            if event.failure is not None:
                self.faults.inject(event.failure, self._rig.sample)
            if event.push is not None:
                self._rig.set_disturbance(event.push)
            self._on_event(event, self._rig.sample)

    def _send(self, frame: TxFrame, transmission: int = 0) -> None:
        for arbitration_id, data, error in self.faults.frames(transmission, frame, self._rig.sample - 1):
            try:
                self._bus.send(arbitration_id, data, error=error)
            except BusError as failure:
                self.send_failures += 1
                self.reason = str(failure)

    def _receive_commands(self) -> None:
        for _ in range(_MAX_FRAMES):
            try:
                frame = self._bus.receive(0.0)
                if frame is None:
                    return
                if self._is_command(frame):
                    motor_1, motor_2 = self._frames.read_command(bytes(frame.data))
                    self._rig.command(motor_1, motor_2)
                    self.commands += 1
            except (MalformedFrame, FrameError):
                self.bad_frames += 1
            except BusError as error:
                self.reason = str(error)
                return

    def _is_command(self, frame: Frame) -> bool:
        return frame.arbitration_id == self._frames.command_id and not frame.is_error_frame and not self.faults.bus_off


def _text(error: Exception) -> str:
    return f"{type(error).__name__}: {' '.join(str(error).split())}"
