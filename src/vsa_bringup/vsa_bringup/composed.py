# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Driver, estimators and joint in one process: samples and estimates are passed on by function calls.

Parameters, topics and services are those of the nodes in separate processes. A parameter file with several joints
(`/left/driver`, `/right/driver`) gets one process for each.
"""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from functools import partial
from select import select
from typing import Any

from rclpy.executors import Executor
from rclpy.subscription import Subscription
from rclpy.timer import Timer
from vsa_common.config.configuration import ConfigurationError
from vsa_common.config.joints import joints
from vsa_common.ros.arguments import check_arguments
from vsa_common.ros.idle import Coalescer
from vsa_common.ros.node import SuiteNode
from vsa_common.ros.process import ignore_signals, run
from vsa_common.ros.subprocesses import end_with
from vsa_driver.acquisition.channel import Measurement
from vsa_driver.node import DriverNode
from vsa_estimator.node import EstimatorNode
from vsa_estimator.output.estimate import Estimate
from vsa_estimator.output.messages import impedance_fields
from vsa_joint.node import JointNode, transmission_estimate

SILENCE_CHECK_NS = 5_000_000  # [ns] between two checks of both sides for a timeout, in stamps of the samples
SIDE_DELAY_NS = 10_000_000  # [ns] allowed between the frames of the two sides of one sample
WAIT_S = 1e-3  # [s] a turn waits for a frame; callbacks of the executor get a turn as often under a continuous load
MAX_CALLBACKS = 10  # callbacks after one turn at most, so that a long turn does not delay the next frames further
MAX_FRAMES = 4  # frames read from one bus per turn, so that a burst on it does not delay other buses and timers
THREAD_SWITCH_S = 1e-4  # [s] Python's thread switch interval, for bus interfaces that need a thread


class DirectJoint(JointNode):
    """Joint node that gets the estimates of both sides by calls of `take`, without subscriptions."""

    def listen(self) -> list[Subscription]:
        return []


class DirectEstimator(EstimatorNode):
    """Estimator node that gets samples by calls of `process` and passes estimates to `joint` before publishing."""

    def __init__(self, namespace: str, side: int, joint: JointNode) -> None:
        name, transmission = f"estimator_{side + 1}", f"transmission_{side + 1}"
        super().__init__(name, namespace, transmission=transmission)
        if self.config.transmission != transmission:
            self.refuse_start(f"transmission = {self.config.transmission!r}: must be {transmission}")
        self._side = side
        self._joint = joint
        self._state_pending: Estimate | None = None  # the estimate whose state is to be published

    def create_inputs(self) -> list[Subscription]:
        return []

    def create_watchdogs(self) -> list[Timer]:
        return []  # the driver calls `predict_silence`

    def process(self, stamp_ns: int, force: float, deflection: float) -> None:
        with self.lock:
            if self.active and not self.refuse(stamp_ns, "force"):
                while self.finish_pending():
                    pass
                super().process(stamp_ns, force, deflection)

    def on_published(self) -> None:
        """Pending work waits for the other side's sample."""

    def on_state_due(self, estimate: Estimate) -> None:
        self._state_pending = estimate

    def finish_pending(self) -> bool:
        with self.lock:
            if super().finish_pending():
                return True
            estimate, self._state_pending = self._state_pending, None
            if estimate is not None and self.active:
                self.publish_state(estimate)
            return estimate is not None

    def on_estimate(self, estimate: Estimate) -> None:
        self._joint.take(self._side, transmission_estimate(estimate.stamp_ns, impedance_fields(estimate)))
        super().on_estimate(estimate)


class DirectDriver(DriverNode):
    """Driver node that passes each sample to its estimator before it publishes it, and requests predictions in silence.

    All of it in the thread that reads the bus, so that every received frame is processed before a timeout is declared.
    """

    def __init__(self, namespace: str, joint: JointNode, single_threaded: bool) -> None:
        super().__init__(namespace=namespace, single_threaded=single_threaded)
        sides = [int(name[-1]) - 1 for name in self.config.transmissions]
        estimators = [DirectEstimator(namespace, side, joint) for side in sides]
        self.estimators: Mapping[str, EstimatorNode] = {one.config.transmission: one for one in estimators}

    def start(self) -> None:
        self._checked_ns = 0
        self.on_idle = self._on_idle
        super().start()

    def on_sample(self, sample: Measurement) -> None:
        estimator = self.estimators[sample.transmission]
        if sample.sequence is not None:
            estimator.count((sample.stamp_ns,), (sample.sequence,))
        estimator.process(sample.stamp_ns, sample.force, sample.deflection)
        super().on_sample(sample)
        if not 0 <= sample.stamp_ns - self._checked_ns < SILENCE_CHECK_NS:
            self._checked_ns = sample.stamp_ns
            for estimator in self.estimators.values():  # by stamps: frames of the other side may be unread
                estimator.predict_silence(sample.stamp_ns - SIDE_DELAY_NS - estimator.stamp_ns)

    def _on_idle(self, until_ns: int) -> None:
        """Without a frame until `until_ns`: one step of pending work, so that the next sample is not delayed."""
        if not any(estimator.finish_pending() for estimator in self.estimators.values()):
            for estimator in self.estimators.values():
                estimator.predict_silence(until_ns - estimator.arrival_ns)


def nodes(namespace: str, single_threaded: bool = False) -> list[SuiteNode[Any]]:
    """The nodes of one joint, in the order of their start; with `single_threaded` `BusSpinner` reads the bus."""
    joint = DirectJoint(namespace=namespace)
    driver = DirectDriver(namespace, joint, single_threaded)
    return [joint, *driver.estimators.values(), driver]


class BusSpinner:
    """Turns of one thread that reads the buses and, in between, serves timers and services.

    While the thread is busy it pauses for `pause_s` [s] whenever no frame is left to read.
    """

    def __init__(self, pause_s: float = 0.0) -> None:
        self._served = 0.0  # instant of the last turn of the executor [s]
        self._coalescer = Coalescer(pause_s)

    def __call__(self, executor: Executor, nodes: Sequence[SuiteNode[Any]], wait_s: float) -> None:
        """One turn: at most MAX_FRAMES of each bus, then one callback of the executor per elapsed WAIT_S."""
        drivers = (node for node in nodes if isinstance(node, DirectDriver) and node.active)
        links = [driver.link for driver in drivers if driver.link.single_threaded]
        waited_for = [link.fileno() for link in links if link.fileno() >= 0]
        pause = self._coalescer.pause()
        ready = select(waited_for, [], [], 0.0 if pause > 0.0 else min(wait_s, WAIT_S))[0]
        for link in links:
            for _ in range(MAX_FRAMES):
                if not link.step(0.0):
                    break
        now = time.monotonic()
        due = min(int((now - self._served) / WAIT_S), MAX_CALLBACKS)  # `spin_once` serves a single callback
        if not ready or due:
            self._served = now
            for _ in range(max(due, 1)):
                executor.spin_once(timeout_sec=0.0)
        if pause > 0.0 and not ready:
            time.sleep(pause)


def run_each(namespaces: Sequence[str]) -> int:
    """Run one process for each joint, as Python runs one thread at a time; the largest absolute exit code."""
    processes: list[subprocess.Popen[bytes]] = []

    def forward(number: int, _: object) -> None:
        for process in processes:
            process.send_signal(number)

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, forward)
    command, parent = [sys.executable, "-m", "vsa_bringup.composed", *sys.argv[1:]], os.getpid()
    for namespace in namespaces:
        own = [*command, "-r", f"__ns:=/{namespace}"]
        processes.append(subprocess.Popen(own, preexec_fn=partial(end_with, parent)))
    code = max(abs(process.wait()) for process in processes)
    ignore_signals()
    return code


def main() -> int:
    """Entry point."""
    sys.setswitchinterval(THREAD_SWITCH_S)
    try:
        check_arguments(sys.argv, __doc__)
        found = joints(sys.argv)
    except ConfigurationError as error:
        print(f"composed: {error}", file=sys.stderr)
        return 1
    return run_each(found) if len(found) > 1 else run(lambda: nodes(found[0], single_threaded=True), turn=BusSpinner)


if __name__ == "__main__":
    sys.exit(main())
