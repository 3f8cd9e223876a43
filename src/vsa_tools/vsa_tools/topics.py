# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The topics of the suite with their types, as docs/reference/interfaces.md lists them."""

WRENCH = "geometry_msgs/msg/WrenchStamped"
JOINT_STATE = "sensor_msgs/msg/JointState"

TRANSMISSIONS = ("transmission_1", "transmission_2")
OF_A_TRANSMISSION = {
    "force": WRENCH,
    "encoder": JOINT_STATE,
    "capture_counters": "vsa_msgs/msg/CaptureCounters",
    "impedance": "vsa_msgs/msg/TransmissionImpedance",
    "estimator_state": "vsa_msgs/msg/EstimatorState",
}
OF_A_JOINT = {
    "joint_impedance": "vsa_msgs/msg/JointImpedance",
    "joint_states": JOINT_STATE,
    "external_torque": WRENCH,
    "motor_states": JOINT_STATE,
    "motor_commands": JOINT_STATE,
    "stiffness_command": "vsa_msgs/msg/StiffnessCommand",
    "stiffness_controller/status": "diagnostic_msgs/msg/DiagnosticStatus",
}
DIAGNOSTICS = {"/diagnostics": "diagnostic_msgs/msg/DiagnosticArray"}


def suite_topics(namespace: str = "/vsa") -> dict[str, str]:
    """Type by name of every topic of one joint.

    >>> suite_topics("/left")["/left/transmission_1/force"]
    'geometry_msgs/msg/WrenchStamped'
    """
    space = "/" + namespace.strip("/") if namespace.strip("/") else ""
    of_transmissions = {
        f"{space}/{transmission}/{name}": type_name
        for transmission in TRANSMISSIONS
        for name, type_name in OF_A_TRANSMISSION.items()
    }
    return of_transmissions | {f"{space}/{name}": kind for name, kind in OF_A_JOINT.items()} | DIAGNOSTICS
