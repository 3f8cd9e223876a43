# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Call a service of the suite without the ros2 command.

python examples/call.py driver/tare
python examples/call.py driver/arm true
"""

import sys

import rclpy
from std_srvs.srv import SetBool, Trigger


def main(service: str, value: str | None = None) -> int:
    rclpy.init()
    node = rclpy.create_node("call", namespace="vsa")
    kind, request = (Trigger, Trigger.Request()) if value is None else (SetBool, SetBool.Request(data=value == "true"))
    client = node.create_client(kind, service)
    if not client.wait_for_service(10.0):
        print(f"call: no server of /vsa/{service}", file=sys.stderr)
        return 1
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future, timeout_sec=10.0)
    if not future.done():
        print(f"call: /vsa/{service} gave no answer", file=sys.stderr)
        return 1
    answer = future.result()
    print(answer.message or ("done" if answer.success else "refused"))
    return 0 if answer.success else 1


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
