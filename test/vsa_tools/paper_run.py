# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""A recording of the paper's two transmissions with known numbers, for tests: equation (20), Table I, SI."""

from pathlib import Path

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import WrenchStamped
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState
from vsa_common.io.bags import Recording
from vsa_common.stamps import set_stamp
from vsa_msgs.msg import CaptureCounters, EstimatorState, JointImpedance, TransmissionImpedance

START_NS = 1_750_000_000_000_000_000
DELAY_NS = 2_000_000  # from stamp to recorder
LAWS = {  # F0, k1, k2, d1, d2, m
    1: (16.39, 0.776, 267.2, 4000.0, -0.1089e9, 0.3755),
    2: (8.269, 7.031, 165.6, 4000.0, -0.1170e9, 0.2295),
}
VALID_AFTER = 2.0  # [s] from which on the estimates are valid
LOST = 37  # the sample whose frame is lost
COVARIANCE = [4e-6] * 4  # of ln stiffness at the two knots
RADIUS, TENDON = 0.0215, 1e5


def motion(side, time):
    """Deflection, velocity and acceleration; slow enough for the damper."""
    middle, travel, turn = 0.008, 0.002, 2.0 * np.pi * (0.2 if side == 1 else 0.25)
    return (
        middle + travel * np.sin(turn * time),
        travel * turn * np.cos(turn * time),
        -travel * turn**2 * np.sin(turn * time),
    )


def truth(side, time):
    """Columns of the rig's truth file for one transmission."""
    offset, k1, k2, d1, d2, mass = LAWS[side]
    x, v, a = motion(side, time)
    elastic = k1 * np.exp(k2 * x)
    return {
        "deflection": x,
        "velocity": v,
        "acceleration": a,
        "force": offset + elastic + d1 * v + d2 * v**3 + mass * a,
        "stiffness": k2 * elastic,
        "damping": d1 + 3.0 * d2 * v**2,
        "inertia": np.full_like(x, mass),
    }


def exponential_knots(side):
    """Deflections [m] and ln stiffness of the two knots of one transmission's law."""
    _, k1, k2, *_ = LAWS[side]
    knots = [0.008, 0.008 + 1.0 / k2]
    return knots, [float(np.log(k1 * k2) + k2 * x) for x in knots]


def write_truth(path, seconds, rate):
    """The rig's truth file."""
    time = np.arange(round(seconds * rate)) / rate
    columns = {"sample": np.arange(len(time)), "time": time}
    for side in LAWS:
        columns |= {f"{name}_{side}": value for name, value in truth(side, time).items()}
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="")


def write_run(path: Path, seconds=4.0, rate=200.0, leaves=None, space="/vsa", close=True, seed=1):
    """A bag as the suite records it; `leaves` restricts it to topics with these last parts."""
    recording = Recording(path)
    random = np.random.default_rng(seed)
    time = np.arange(round(seconds * rate)) / rate
    stamps = START_NS + np.round(time * 1e9).astype(np.int64)
    rows = []
    for side in LAWS:
        rows += _side(side, time, stamps, random, int(rate // 50), int(rate // 10))
    rows += _joint(time, stamps)
    status = DiagnosticStatus(level=bytes([1]), name="/vsa/estimator_1", message="converging")
    fine = DiagnosticStatus(level=bytes([0]), name="/vsa/joint", message="active")
    for k in range(int(seconds)):
        message = DiagnosticArray(status=[status, fine] if k < VALID_AFTER else [fine])
        rows.append((START_NS + k * 10**9, "/diagnostics", serialize_message(message)))
    types = {}
    for stamp_ns, name, data in sorted(rows, key=lambda row: row[0]):
        leaf = name.rsplit("/", 1)[-1]
        if leaves is None or leaf in leaves:
            topic = name if name.startswith("/") else f"{space}/{name}"
            if topic not in types:
                types[topic] = _TYPES[leaf]
                recording.add(topic, _TYPES[leaf])
            recording.write(topic, int(stamp_ns) + DELAY_NS, data)
    if close:
        recording.close()
    else:
        recording.flush()
    return recording


_TYPES = {
    "force": "geometry_msgs/msg/WrenchStamped",
    "encoder": "sensor_msgs/msg/JointState",
    "impedance": "vsa_msgs/msg/TransmissionImpedance",
    "estimator_state": "vsa_msgs/msg/EstimatorState",
    "capture_counters": "vsa_msgs/msg/CaptureCounters",
    "joint_impedance": "vsa_msgs/msg/JointImpedance",
    "joint_states": "sensor_msgs/msg/JointState",
    "external_torque": "geometry_msgs/msg/WrenchStamped",
    "diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
}


def _side(side, time, stamps, random, every_state, every_batch):
    name = f"transmission_{side}"
    offset, k1, k2, d1, d2, mass = LAWS[side]
    true = truth(side, time)
    force, encoder, impedance, state = WrenchStamped(), JointState(), TransmissionImpedance(), EstimatorState()
    batch = CaptureCounters()
    for message in (force, encoder, impedance, state, batch):
        message.header.frame_id = name
    encoder.name, encoder.velocity, encoder.effort = [name], [0.0], [0.0]
    rows = []
    for k, (t, stamp_ns) in enumerate(zip(time, stamps.tolist(), strict=True)):
        if k == LOST:
            continue
        known = bool(t >= VALID_AFTER)
        std = 0.002 if known else 0.3
        for message in (force, encoder, impedance):
            set_stamp(message.header.stamp, stamp_ns)
        force.wrench.force.x = true["force"][k] + 0.017 * random.standard_normal()
        encoder.position = [true["deflection"][k] + 1e-5 * random.standard_normal()]
        impedance.force, impedance.force_valid = force.wrench.force.x, True
        for field, scale in (("deflection", 2e-6), ("velocity", 2e-5), ("acceleration", 1e-3)):
            setattr(impedance, field, true[field][k] + scale * random.standard_normal())
            setattr(impedance, f"{field}_variance", scale**2)
            setattr(impedance, f"{field}_valid", True)
        for field in ("stiffness", "damping", "inertia"):
            value = true[field][k]
            setattr(impedance, field, value * (1.0 + std * random.standard_normal()))
            setattr(impedance, f"{field}_variance", (std * value) ** 2)
            setattr(impedance, f"{field}_valid", known and field != "inertia")
        impedance.status = 2 if known else 1
        rows.append((stamp_ns, f"{name}/force", serialize_message(force)))
        rows.append((stamp_ns, f"{name}/encoder", serialize_message(encoder)))
        rows.append((stamp_ns, f"{name}/impedance", serialize_message(impedance)))
        batch.stamp.append(impedance.header.stamp.__class__(sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9))
        batch.counter.append(k)
        if k % every_batch == every_batch - 1 or k == len(time) - 1:
            set_stamp(batch.header.stamp, stamp_ns)
            rows.append((stamp_ns, f"{name}/capture_counters", serialize_message(batch)))
            batch.stamp, batch.counter = [], []
        if k % every_state == 0:
            set_stamp(state.header.stamp, stamp_ns)
            for field, value in (("k2", k2), ("d1", d1), ("d2", d2), ("inertia", mass), ("force_offset", offset)):
                setattr(state, field, value * (1.0 + 0.3 * std))
                setattr(state, f"{field}_variance", (std * value) ** 2)
                setattr(state, f"{field}_valid", known and field != "inertia")
            state.deflection_reference, state.ln_stiffness_reference = 0.008, float(np.log(k1 * k2) + k2 * 0.008)
            state.ln_stiffness_reference_valid = known
            state.elastic_law, state.elastic_law_valid = "exponential", known
            state.elastic_deflection, state.elastic_ln_stiffness = exponential_knots(side)
            state.elastic_ln_stiffness_covariance = COVARIANCE
            state.elastic_force = offset + float(np.exp(state.elastic_ln_stiffness[0])) / k2
            variances = [
                std**2,
                *(getattr(state, f"{one}_variance") for one in ("k2", "d1", "d2", "inertia")),
                0.01,
                0.01,
            ]
            state.coefficient_covariance = np.diag(variances).ravel()
            state.force_innovation = 0.017 * random.standard_normal()
            state.deflection_innovation = 1e-5 * random.standard_normal()
            state.normalised_innovation_squared = (state.force_innovation / 0.017) ** 2
            state.force_noise_std, state.deflection_noise_std = 0.017, 1e-5
            state.samples_fused, state.force_rejected, state.status = k + (k < LOST), 3, impedance.status
            rows.append((stamp_ns, f"{name}/estimator_state", serialize_message(state)))
    return rows


def _joint(time, stamps):
    message, angle, torque = JointImpedance(), JointState(), WrenchStamped()
    angle.velocity, angle.effort = [0.0], [0.0]
    sides = [truth(side, time) for side in LAWS]
    branch = [TENDON / (4.0 * TENDON + one["stiffness"]) for one in sides]
    stiffness = RADIUS**2 * sum(one["stiffness"] * b for one, b in zip(sides, branch, strict=True))
    damping = RADIUS**2 * sum(one["damping"] * 4.0 * b**2 for one, b in zip(sides, branch, strict=True)) + 0.01
    rows = []
    for k, stamp_ns in enumerate(stamps.tolist()):
        for one in (message, angle, torque):
            set_stamp(one.header.stamp, stamp_ns)
        valid = bool(time[k] >= VALID_AFTER)
        message.stiffness, message.damping, message.inertia = stiffness[k], damping[k], 1e-3
        message.stiffness_variance, message.damping_variance = (0.01 * stiffness[k]) ** 2, (0.02 * damping[k]) ** 2
        message.stiffness_valid = message.damping_valid = valid
        message.tension = [one["force"][k] / 2.0 for one in sides]
        message.co_contraction = float(min(message.tension))
        message.status = 2 if valid else 1
        angle.name, angle.position = ["joint"], [0.1 * np.sin(time[k])]
        torque.wrench.torque.z = 0.2 * np.cos(time[k])
        rows.append((stamp_ns, "joint_impedance", serialize_message(message)))
        rows.append((stamp_ns, "joint_states", serialize_message(angle)))
        rows.append((stamp_ns, "external_torque", serialize_message(torque)))
    return rows
