# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""rosbag2 recordings, read and written without ROS. Input: path of a bag. Output: messages, or a bag (MCAP).

Permitted imports: ament_index_python, mcap, rosbags

>>> for topic, receive_ns, message in read("demo/bag", ["/vsa/joint_impedance"]):  # doctest: +SKIP
...     print(message.stiffness)
"""

from vsa_common.io.bags.definitions import BagError
from vsa_common.io.bags.reader import Topic, fields, read, read_raw, topics
from vsa_common.io.bags.writer import Recording

__all__ = ["BagError", "Recording", "Topic", "fields", "read", "read_raw", "topics"]
