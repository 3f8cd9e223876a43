# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Options of the live page."""

import os

from vsa_tools.view.command import main


def test_an_invalid_namespace_is_a_one_line_error(monkeypatch, capsys):
    monkeypatch.setattr(os, "nice", lambda step: step)  # of the process of the tests
    assert main(["--namespace", "my-rig"]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert error.startswith("view: --namespace my-rig: ")
