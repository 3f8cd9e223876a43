# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The command `bench view`."""

from vsa_bench.view import command


def test_ctrl_c_ends_the_runs_with_one_line(monkeypatch, capsys):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(command, "companions", lambda *_: {command.NONE: None})
    monkeypatch.setattr(command, "run_case", interrupted)
    assert command.main(["--repeat", "1"]) == 130
    assert capsys.readouterr().err.endswith("bench view: stopped\n")
