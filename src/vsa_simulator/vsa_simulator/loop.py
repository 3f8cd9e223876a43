"""The simulated rig in real time: a thread that keeps its clock, sends its frames and obeys its commands."""

import threading
import time
from collections import deque
from collections.abc import Callable, Sequence

from vsa_driver.can.bus import Bus, BusError, Frame, MalformedFrame
from vsa_driver.can.frames import FrameError
from vsa_simulator.faults.failure import Event
from vsa_simulator.faults.injection import Faults, Outgoing
from vsa_simulator.frames import RigFrames
from vsa_simulator.ground_truth import TruthFile
from vsa_simulator.pacing import Pacer
from vsa_simulator.rig.rig import Rig

_IDLE_S = 0.01  # between two looks at the bus while the clock stands
_BREATH_S = 0.0005  # between two bursts, for those who read the bus
_READ_AT_MOST = 64  # frames taken from the bus between two samples


class RigLoop:
    """Runs `rig` on `bus` until `close`, for `samples` samples; their truth goes to `truth`.

    `events` happen at their times; `on_event`, called from the rig's thread, is told of each with its sample.
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
        self.commands = 0  # frames taken
        self.bad_frames = 0  # command frames that were none, datagrams that were no frames
        self.send_failures = 0
        self.reason = ""  # of the last failure to send
        self.faults = Faults(rig.config.rate_hz, rig.config.sensors, rig.config.seed)
        self._rig, self._bus, self._frames, self._truth = rig, bus, frames, truth
        self._slow_every = slow_every
        self._samples = samples
        self._events = deque(events)
        self._at_once: deque[Event] = deque()
        self._on_event = on_event
        self._pacer = Pacer(rig.config.rate_hz)
        self._wanted = threading.Event()  # whether the clock shall run
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="rig", daemon=True)

    @property
    def sent(self) -> int:
        """Samples that were sent so far."""
        return self._rig.sample

    @property
    def done(self) -> bool:
        """Whether the last sample was sent."""
        return self._samples is not None and self._rig.sample >= self._samples

    @property
    def running(self) -> bool:
        """Whether the rig's clock runs."""
        return self._wanted.is_set() and not self.done

    @property
    def overruns(self) -> int:
        """Samples that were sent after the next one was due."""
        return self._pacer.overruns

    @property
    def holding(self) -> bool:
        """Whether the motors hold because commands have stopped."""
        return self._rig.holding

    def happen(self, event: Event) -> None:
        """Let `event` happen with the next sample."""
        self._at_once.append(event)

    def open(self) -> None:
        """Begin, with the clock standing."""
        self._thread.start()

    def start_clock(self) -> None:
        """Let the clock run from where it stands."""
        self._wanted.set()

    def stop_clock(self) -> None:
        """Stop the clock; the rig stands still."""
        self._wanted.clear()

    def close(self) -> None:
        """Stop the thread, wait for it, close bus and truth file."""
        self._closing.set()
        self._thread.join()
        self._bus.close()
        if self._truth is not None:
            self._truth.close()

    def _run(self) -> None:
        while not self._closing.is_set():
            if not self.running:
                self._pacer.stop()
                self._listen()
                self._closing.wait(_IDLE_S)
                continue
            if not self._pacer.running:
                self._pacer.start(time.monotonic_ns())
            for _ in range(self._pacer.due(time.monotonic_ns())):
                self._step()
            self._listen()
            pause = self._pacer.wait(time.monotonic_ns())
            time.sleep(pause if pause > 0.0 else _BREATH_S)

    def _step(self) -> None:
        if self.done:
            return
        self._take_events()
        first, truth, readings = self._rig.advance(1)
        if self.faults.active:
            self.faults.expire(first)
        said = self.faults.readings(readings, first)
        pair = [self._frames.transmission(side, first, said[side], int(said[2 + side])) for side in range(2)]
        for side, frame in enumerate(pair, 1):  # one right behind the other: both are of one instant
            self._send(frame, side)
        number, rest = divmod(first, self._slow_every)
        if rest == 0:
            self._send(self._frames.joint(number, said[4], said[5]))
            motor_1, motor_2 = readings.motors[0].tolist()
            self._send(self._frames.motors(number, (motor_1, motor_2), self._rig.holding))
        if self._truth is not None:
            self._truth.write(first, truth[0].tolist())

    def _take_events(self) -> None:
        while self._events and self._events[0].at <= self._rig.time:
            self._at_once.append(self._events.popleft())
        while self._at_once:
            event = self._at_once.popleft()
            if event.failure is not None:
                self.faults.inject(event.failure, self._rig.sample)
            if event.push is not None:
                self._rig.push = event.push
            self._on_event(event, self._rig.sample)

    def _send(self, frame: Outgoing, transmission: int = 0) -> None:
        going = self.faults.frames(transmission, frame, self._rig.sample - 1)
        for arbitration_id, data, error in going:
            try:
                self._bus.send(arbitration_id, data, error=error)
            except BusError as failure:
                self.send_failures += 1
                self.reason = str(failure)

    def _listen(self) -> None:
        for _ in range(_READ_AT_MOST):
            try:
                frame = self._bus.receive(0.0)
                if frame is None:
                    return
                if self._for_the_rig(frame):
                    motor_1, motor_2 = self._frames.read_command(bytes(frame.data))
                    self._rig.command(motor_1, motor_2)
                    self.commands += 1
            except (MalformedFrame, FrameError):
                self.bad_frames += 1
            except BusError as error:
                self.reason = str(error)
                return

    def _for_the_rig(self, frame: Frame) -> bool:
        return frame.arbitration_id == self._frames.command_id and not frame.is_error_frame and not self.faults.silent
