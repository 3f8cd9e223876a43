# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Start of the nodes of a demo: answers of a service that get lost."""

import pytest
from vsa_tools.demo.harness import ProcessHarness, ProcessSpec
from vsa_tools.demo.isolation import claim_domain
from vsa_tools.demo.parameters import base_parameters, write_parameters

pytestmark = pytest.mark.live


def test_a_transition_whose_answer_gets_lost_is_found_by_the_state(tmp_path, monkeypatch):
    domain = claim_domain()
    bus = {"interface": "udp_multicast", "options": ["hop_limit=0", f"port={domain.bus_port}"]}
    write_parameters(tmp_path / "parameters.yaml", base_parameters(), {"driver": {"autostart": False, "bus": bus}})
    lost = []

    def without_first_answer(harness, client, request):
        answer = ask(harness, client, request)
        if answer is None or client.srv_name.endswith("get_state") or request.transition.id in lost:
            return answer
        lost.append(request.transition.id)
        return None

    ask = ProcessHarness._try_call
    monkeypatch.setattr(ProcessHarness, "_try_call", without_first_answer)
    with ProcessHarness(domain.environment(), tmp_path / "logs") as harness:
        harness.start([ProcessSpec("driver", "vsa_driver", "driver")], tmp_path / "parameters.yaml")
        harness.activate("driver")
        harness.wait_until_active("driver")
    assert len(lost) == 2
