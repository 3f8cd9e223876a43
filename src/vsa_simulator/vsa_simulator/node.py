# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Node: the simulated rig on a CAN bus, in a process of its own."""

import gc
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import yaml
from std_srvs.srv import Trigger
from vsa_common.config.configuration import ConfigurationError, flag, group, quantity, string
from vsa_common.ros.diagnostics import CounterDelta
from vsa_common.ros.node import ERROR, OK, STEADY, WARN, Health, SuiteNode, Tasks
from vsa_common.ros.process import run
from vsa_driver.acquisition.mapping import load_frames
from vsa_driver.can.bus import BusConfig, open_bus
from vsa_driver.can.frames import FrameError
from vsa_msgs.srv import InjectFailure
from vsa_simulator.faults.failure import Event, FailureError, parse, scenario
from vsa_simulator.frames import RigFrames
from vsa_simulator.ground_truth import TruthFile
from vsa_simulator.loop import RigLoop
from vsa_simulator.rig.config import RigConfig
from vsa_simulator.rig.rig import Rig

SIMULATION = "simulation"  # task of the diagnostics
MAX_LATE_SHARE = 0.05  # of the samples of the last second; single late ones are usual without real-time priority


@dataclass(frozen=True)
class SimulatorConfig(RigConfig):
    """Parameters of the rig, its bus, its clock and its ground truth."""

    bus: BusConfig = group(BusConfig)
    dbc: str = string("package://vsa_driver/config/vsa_rig.dbc", "DBC file: a path, or package://package/path")
    slow_frames_every: int = quantity(5, "sample", 1, 1000, "samples between two frames of joint and motor state")
    duration: float = quantity(0.0, "s", 0.0, 1e9, "time after which the rig stops; 0: no limit")
    truth_file: str = string("", "CSV file for the ground truth of every sample; empty: none")
    scenario: str = string("", "YAML file of failures and disturbance torques with their times; empty: none")
    autostart_clock: bool = flag(True, "start the rig's clock at once; else by the service ~/start")


class RigSimulatorNode(SuiteNode[SimulatorConfig]):
    """Run the rig in real time on a CAN bus."""

    def __init__(self) -> None:
        super().__init__("rig_simulator", SimulatorConfig)

    def configure(self) -> None:
        """Read the DBC file and the scenario, and open the bus once."""
        _frames(self.config.dbc)
        _events(self.config.scenario)
        open_bus(self.config.bus).close()

    def start(self) -> None:
        config = self.config
        frames = _frames(config.dbc)
        events = _events(config.scenario)
        begin = time.monotonic()
        Rig(config).advance(1)  # compiles, or loads the compiled code
        samples = round(config.duration * config.rate_hz) if config.duration else None
        bus = open_bus(config.bus)
        try:
            truth = TruthFile(config.truth_file) if config.truth_file else None
        except OSError as error:
            bus.close()
            raise ConfigurationError(f"truth_file = {config.truth_file!r}: {error.strerror}") from error
        bus.ignore(frames.sent_ids)
        gc.freeze()
        self._loop = RigLoop(Rig(config), bus, frames, config.slow_frames_every, samples, truth, events, self._on_event)
        self._loop.open()
        self._completion_logged = False
        self._delta = CounterDelta()
        self._own_services = [
            self.create_service(Trigger, "~/start", self._on_start),
            self.create_service(Trigger, "~/stop", self._on_stop),
            self.create_service(InjectFailure, "~/failure", self._on_failure),
        ]
        self._timer = self.create_timer(0.1, self._log_completion, clock=STEADY)
        self.get_logger().info(f"rig ready at {config.rate_hz} Hz after {time.monotonic() - begin:.1f} s on {bus.name}")
        if config.autostart_clock:
            self._loop.start_clock()

    def stop(self) -> None:
        self._loop.close()
        if self._loop.failure:
            self.get_logger().error(f"the rig has failed: {self._loop.failure}")
        self.destroy_timer(self._timer)
        for service in self._own_services:
            self.destroy_service(service)

    def health(self) -> Tasks:
        return {SIMULATION: self._simulation()}

    @property
    def tasks(self) -> tuple[str, ...]:
        return (SIMULATION,)

    @property
    def hardware_id(self) -> str:
        return "simulated rig"

    @property
    def activity(self) -> str:
        return f"CAN bus {self.config.bus.interface} {self.config.bus.channel}, {self.config.rate_hz} Hz"

    def _simulation(self) -> Health:
        loop = self._loop
        state = "done" if loop.done else "running" if loop.running else "clock stopped"
        values: dict[str, object] = {
            "samples": loop.sent,
            "overruns": loop.overruns,
            "send_failures": loop.send_failures,
            "commands": loop.commands,
            "bad_frames": loop.bad_frames,
            "motors": "holding" if loop.holding else "moving",
            "failures": ", ".join(map(str, loop.faults.active)) or "none",
        }
        if loop.failure:
            return ERROR, f"the rig has failed: {loop.failure}", values
        increases = self._delta.increases({"late": loop.overruns, "failed": loop.send_failures}, time.monotonic())
        if "failed" in increases:
            return WARN, f"{increases['failed']} frames not sent in the last second: {loop.reason}", values
        if loop.faults.active:
            return WARN, f"failures injected: {values['failures']}", values
        late = increases.get("late", 0)
        if late > MAX_LATE_SHARE * self.config.rate_hz:
            return WARN, f"{late} samples late in the last second", values
        return OK, state, values

    def _on_start(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        if self._loop.failure:
            response.message = f"the rig has failed: {self._loop.failure}"
            return response
        self._loop.start_clock()
        response.success, response.message = True, f"clock runs from sample {self._loop.sent}"
        return response

    def _on_stop(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._loop.stop_clock()
        response.success, response.message = True, f"clock stopped at sample {self._loop.sent}"
        return response

    def _on_failure(self, request: InjectFailure.Request, response: InjectFailure.Response) -> InjectFailure.Response:
        try:
            failure = parse(request.failure)
        except FailureError as error:
            response.message = str(error)
            return response
        self._loop.inject(Event(0.0, failure))
        response.success, response.message = True, str(failure)
        return response

    def _on_event(self, event: Event, sample: int) -> None:
        name = f"failure {event.failure}" if event.failure else f"push {event.push} N m"
        self.get_logger().info(f"{name} from sample {sample}, {sample / self.config.rate_hz:.3f} s")

    def _log_completion(self) -> None:
        if self._loop.done and not self._completion_logged:
            self._completion_logged = True
            late, failed = self._loop.overruns, self._loop.send_failures
            self.get_logger().info(f"done: {self._loop.sent} samples, {late} late, {failed} frames not sent")


def _frames(dbc: str) -> RigFrames:
    try:
        return RigFrames(load_frames(dbc))
    except FrameError as error:
        raise ConfigurationError(f"dbc = {dbc!r}: {error}") from error


def _events(path: str) -> tuple[Event, ...]:
    if not path:
        return ()
    try:
        return scenario(yaml.safe_load(Path(path).read_text()))
    except (OSError, yaml.YAMLError, FailureError) as error:
        raise ConfigurationError(f"scenario = {path!r}: {' '.join(str(error).split())}") from error


def main() -> int:
    """Entry point."""
    return run(RigSimulatorNode)


if __name__ == "__main__":
    sys.exit(main())
