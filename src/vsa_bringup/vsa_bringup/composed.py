"""Driver, estimators and joint in one process: every sample goes from one to the next by a function call.

The same nodes with the same parameters, topics and services as in processes of their own; what they publish goes out
beside. A parameter file that names several joints (`/left/driver`, `/right/driver`) gets them all.
"""

import sys
from collections.abc import Mapping
from typing import Any

from rclpy.subscription import Subscription
from vsa_common.configuration import ConfigurationError
from vsa_common.joints import joints
from vsa_common.node import SuiteNode, run
from vsa_driver.capture import Sample
from vsa_driver.driver import DriverNode
from vsa_estimator.node import EstimatorNode, impedance_of
from vsa_estimator.values import Estimate
from vsa_joint.joint import JointNode, side_of

TELL = 0.005  # how soon a state is told that is due [s]
SWITCH_S = 1e-4  # of Python's threads: no longer than this a sample waits for a service or a timer


class DirectJoint(JointNode):
    """Is handed the estimates of both sides."""

    def listen(self) -> list[Subscription]:
        return []


class DirectEstimator(EstimatorNode):
    """Is handed samples, and hands its estimates to `joint` before it publishes them."""

    def __init__(self, namespace: str, side: int, joint: JointNode) -> None:
        name, transmission = f"estimator_{side + 1}", f"transmission_{side + 1}"
        super().__init__(name, namespace, transmission=transmission)
        if self.config.transmission != transmission:
            raise ConfigurationError(f"{name}: transmission = {self.config.transmission!r}: must be {transmission}")
        self._side = side
        self._joint = joint
        self._due: Estimate | None = None

    def start(self) -> None:
        super().start()
        self._teller = self.create_timer(TELL, self._tell, clock=self.steady)

    def stop(self) -> None:
        self.destroy_timer(self._teller)
        super().stop()

    def listen(self) -> list[Subscription]:
        return []

    def take(self, stamp_ns: int, force: float, deflection: float) -> None:
        with self.lock:
            if self.active and not self.refuse(stamp_ns, "force"):
                super().take(stamp_ns, force, deflection)

    def on_estimate(self, estimate: Estimate) -> None:
        self._joint.take(self._side, side_of(estimate.stamp_ns, impedance_of(estimate)))
        super().on_estimate(estimate)

    def on_state_due(self, estimate: Estimate) -> None:
        self._due = estimate  # a big message: the next sample shall not wait for it

    def _tell(self) -> None:
        due, self._due = self._due, None
        if due is not None:
            self.tell_state(due)


class DirectDriver(DriverNode):
    """Hands each sample to the estimator of its transmission before it publishes it."""

    estimators: Mapping[str, EstimatorNode]

    def on_sample(self, sample: Sample) -> None:
        self.estimators[sample.transmission].take(sample.stamp_ns, sample.force, sample.deflection)
        super().on_sample(sample)


def nodes(namespace: str) -> list[SuiteNode[Any]]:
    """The nodes of one joint, in the order in which they start."""
    driver, joint = DirectDriver(namespace=namespace), DirectJoint(namespace=namespace)
    sides = [int(name[-1]) - 1 for name in driver.config.transmissions]
    estimators = [DirectEstimator(namespace, side, joint) for side in sides]
    driver.estimators = {estimator.config.transmission: estimator for estimator in estimators}
    return [joint, *estimators, driver]


def main() -> int:
    """Entry point."""
    sys.setswitchinterval(SWITCH_S)
    return run(lambda: [node for joint in joints(sys.argv) for node in nodes(joint)])


if __name__ == "__main__":
    sys.exit(main())
