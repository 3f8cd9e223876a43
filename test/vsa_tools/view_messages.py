# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Serialized messages and a filled view model of the live page, for tests."""

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.serialization import serialize_message
from vsa_common.stamps import set_stamp
from vsa_msgs.msg import CaptureCounters, EstimatorState, JointImpedance, TransmissionImpedance
from vsa_tools.view.view_model import ViewModel

SIDE, STATE, JOINT = (k.get_fields_and_field_types() for k in (TransmissionImpedance, EstimatorState, JointImpedance))


def impedance(stamp_ns=10**9, frame="transmission_1", **values):
    message = TransmissionImpedance(**values)
    message.header.frame_id = frame
    set_stamp(message.header.stamp, stamp_ns)
    return serialize_message(message)


S = 10**9  # [ns]


def diagnostic(level, text, name="/vsa/driver"):
    return DiagnosticArray(status=[DiagnosticStatus(level=bytes([level]), name=name, message=text)])


def counters(stamp_ns, *numbers):
    message = CaptureCounters(counter=numbers)
    set_stamp(message.header.stamp, stamp_ns)
    return serialize_message(message)


def filled_model():
    model = ViewModel(SIDE, STATE, JOINT)
    side = model.transmissions["transmission_1"]
    for k in range(100):
        data = impedance(
            k * 10**7,
            force=3.0 + 0.5 * k * 0.01,
            stiffness=2000.0,
            stiffness_variance=400.0,
            stiffness_valid=True,
            status=2,
        )
        side.add_impedance(data, 10.0)
    joint = JointImpedance(stiffness=0.75, stiffness_valid=True, status=2, reason="one tendon is slack")
    joint.stiffness_range_valid, joint.stiffness_min, joint.stiffness_max = True, 0.5, 2.0
    model.joint.add_impedance(serialize_message(joint), S, 10.0)
    model.joint.set_angle(0.25, 10.0)
    state = EstimatorState(k2=267.2, k2_variance=4.0, k2_valid=True, reset_count=1, reset_reason=4, samples_fused=100)
    state.observability = ["inertia: move faster"]
    side.add_state(serialize_message(state))
    side.add_counters(counters(S, 1, 2, 5))
    model.add_diagnostics(diagnostic(2, "bus off"), S, 10.0, "/vsa/")
    return model
