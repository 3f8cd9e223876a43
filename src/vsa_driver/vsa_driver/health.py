# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Diagnostics of the driver: bus, each transmission, joint and motors."""

import time
from collections.abc import Collection, Mapping, Sequence

from vsa_common.ros.diagnostics import ERROR, OK, WARN, CounterDelta, Health, Tasks, format_increases
from vsa_driver.acquisition.channel import JointChannel, MotorChannel
from vsa_driver.acquisition.router import Router
from vsa_driver.can.link import BusLink
from vsa_driver.motors.motor import MotorGate
from vsa_driver.tuning import MAX_POSITION_AGE_S

BUS, JOINT, MOTORS = "bus", "joint", "motors"  # tasks besides those of the transmissions
MIN_SPAN = 0.5  # [s] over which a rate is measured

_NO_FAULT = ("samples", "unmapped_frames")  # counters whose increase is no fault


def tasks(transmissions: Sequence[str]) -> tuple[str, ...]:
    """Names of the tasks."""
    return BUS, *transmissions, JOINT, MOTORS


class DriverHealth:
    """Health of each task, by the counters of the last second."""

    def __init__(self, router: Router, link: BusLink, gate: MotorGate) -> None:
        """The parts of the driver whose counters are assessed."""
        self._router, self._link, self._gate = router, link, gate
        self._delta = CounterDelta()
        self._begin_s = time.monotonic()
        self._seen: dict[str, tuple[int, float]] = {}  # by message: samples, and when the last one was seen [s]

    def assess(self, silent: Collection[str], max_delay_ns: int, holding: bool) -> Tasks:
        """Health of all tasks.

        `silent` are transmissions without samples, `max_delay_ns` the longest delay from capture to publication,
        `holding` whether the motors' own watchdog holds them.
        """
        router, now_s = self._router, time.monotonic()
        bus = router.counts() | {name: getattr(self._link, name) for name in ("malformed", "failures", "reopened")}
        counts = {BUS: bus, JOINT: {}, MOTORS: self._of_gate()}
        counts |= {name: channel.counts() for name, channel in router.transmissions.items()}
        for channel in router.joint:
            counts[JOINT] |= channel.counts()
        if router.motors is not None:
            counts[MOTORS] |= router.motors.counts()
        flat = {f"{task}.{name}": count for task, one in counts.items() for name, count in one.items()}
        increases = self._delta.increases(flat, now_s)
        found: dict[str, Health] = {
            BUS: self._bus({**bus, "publish_delay_max_ms": round(max_delay_ns / 1e6, 2)}, _of(BUS, increases)),
            **{
                name: self._transmission(name, counts[name], increases, name in silent) for name in router.transmissions
            },
            JOINT: self._joint(counts[JOINT], _of(JOINT, increases), now_s),
            MOTORS: self._motors(counts[MOTORS], _of(MOTORS, increases), holding, now_s),
        }
        return found

    def _bus(self, values: Mapping[str, object], increases: Mapping[str, int]) -> Health:
        link = self._link
        values = {"bus": "up" if link.up else "down", **values}
        if not link.up:
            return ERROR, f"down: {link.reason or 'its thread has ended'}", values
        if "failures" in increases:
            return WARN, f"reopened after: {link.last_reason}", values
        return _counted(values, increases, "active")

    def _transmission(self, name: str, counts: Mapping[str, int], increases: Mapping[str, int], silent: bool) -> Health:
        rate = increases.get(f"{name}.samples", 0) / max(self._delta.span, 1e-3)
        tare = self._router.transmissions[name].tare.offset
        own = {"rate_hz": round(rate, 1), "tare_n": tare, **counts}
        text = f"{rate:.0f} Hz" if self._delta.span > MIN_SPAN else "active"
        health = _counted(own, _of(name, increases), text)
        return _without_samples(health) if silent else health

    def _joint(self, counts: Mapping[str, int], increases: Mapping[str, int], now_s: float) -> Health:
        health = _counted(counts, increases, "active" if self._router.joint else "not mapped")
        silent = [channel for channel in self._router.joint if self._is_silent(channel, now_s)]
        return _without_samples(health) if silent else health

    def _motors(self, counts: Mapping[str, int], increases: Mapping[str, int], holding: bool, now_s: float) -> Health:
        gate, channel = self._gate, self._router.motors
        silent = channel is not None and self._is_silent(channel, now_s)
        values = {
            "motors": gate.state,
            "reason": gate.reason,
            "rate_limited": gate.rate_limited,
            "device_watchdog": "unknown" if silent or channel is None else "holding" if holding else "fed",
            **counts,
        }
        if self._router.motors is None and self._router.commands is None:
            return OK, "not mapped", values
        health = _counted(values, increases, gate.state)
        return _without_samples(health) if silent else health

    def _of_gate(self) -> dict[str, int]:
        """Counters of the faults of commands."""
        return {"commands_refused": self._gate.refused, "command_timeouts": self._gate.timeouts}

    def _is_silent(self, channel: JointChannel | MotorChannel, now_s: float) -> bool:
        """Whether a message of joint or motors has had no sample for MAX_POSITION_AGE_S, since the start at first."""
        samples, (before, seen_s) = channel.stream.samples, self._seen.get(channel.name, (0, self._begin_s))
        if samples != before:
            seen_s = now_s
        self._seen[channel.name] = samples, seen_s
        return now_s - seen_s > MAX_POSITION_AGE_S


def _without_samples(health: Health) -> Health:
    level, text, values = health
    return ERROR, f"no samples; {text}" if level else "no samples", values


def _of(task: str, increases: Mapping[str, int]) -> dict[str, int]:
    """Increases of a task's counters of faults, by their names in the task."""
    own = {name.partition(".")[2]: count for name, count in increases.items() if name.partition(".")[0] == task}
    return {name: count for name, count in own.items() if name not in _NO_FAULT}


def _counted(values: Mapping[str, object], increases: Mapping[str, int], text: str) -> Health:
    return (WARN, format_increases(increases), values) if increases else (OK, text, values)
