# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""The generated blocks of docs/reference: message fields, parameters and launch arguments, from their definitions.

`python -m vsa_tools.reference_tables docs/reference/interfaces.md` renews them between their markers.
"""

import importlib
import math
import re
import sys
from pathlib import Path

from vsa_bringup.arguments import arguments
from vsa_common.config.configuration import Parameter, parameters

NODES = {
    "every_node": "vsa_common.ros.parameters.Common",
    "driver": "vsa_driver.settings.DriverSettings",
    "estimator": "vsa_estimator.settings.NodeConfig",
    "joint": "vsa_joint.settings.JointConfig",
    "stiffness_controller": "vsa_joint.settings.ControlConfig",
    "excitation": "vsa_joint.excitation.settings.ExcitationConfig",
    "recorder": "vsa_tools.record.command.RecorderConfig",
    "rig_simulator": "vsa_simulator.node.SimulatorConfig",
}
_BLOCK = re.compile(r"(<!-- (parameters|tunable|message|launch): (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)
_FIELD = re.compile(r"^(\S+)\s+(\w+)\s*(=\s*\S+)?\s*(?:#\s*(.*))?$")


def document(text: str, messages: Path) -> str:
    """`text` with every generated block renewed; `messages` is the folder of the .msg files."""

    def renew(block: re.Match[str]) -> str:
        head, kind, name, end = block.groups()
        if kind == "launch":
            table = argument_table()
        elif kind == "message":
            table = message_table(messages / f"{name}.msg")
        else:
            table = (parameter_table if kind == "parameters" else tunable_list)(NODES[name])
        return f"{head}{table}{end}"

    return _BLOCK.sub(renew, text)


def argument_table() -> str:
    """Markdown table of the arguments of the launch files."""
    rows = ["| argument | default | values | meaning |", "|---|---|---|---|"]
    for one in arguments():
        rows.append(f"| `{one.name}` | {Path(one.default).name} | {', '.join(one.choices)} | {one.text} |")
    return "\n".join(rows) + "\n"


def parameter_table(config: str) -> str:
    """Markdown table of a configuration class, named with its module."""
    rows = ["| parameter | default | unit | range | meaning |", "|---|---|---|---|---|"]
    rows += [_parameter_row(p) for p in parameters(_class(config))]
    return "\n".join(rows) + "\n"


def tunable_list(config: str) -> str:
    """The tunable parameters of a configuration class."""
    return ", ".join(f"`{p.name}`" for p in parameters(_class(config)) if p.tunable) + "\n"


def _class(config: str) -> type:
    module, _, name = config.rpartition(".")
    return getattr(importlib.import_module(module), name)  # type: ignore[no-any-return]


def _parameter_row(parameter: Parameter) -> str:
    default = list(parameter.default) if isinstance(parameter.default, tuple) else parameter.default
    if parameter.options:
        limits = ", ".join(parameter.options)
    elif math.isfinite(parameter.low):
        limits = f"{parameter.low:g} to {parameter.high:g}"
    else:
        limits = ""
    return f"| `{parameter.name}` | {default} | {parameter.unit} | {limits} | {parameter.text} |"


def message_table(file: Path) -> str:
    """Markdown table of a message definition."""
    notes, rows = [], ["| field | type | meaning |", "|---|---|---|"]
    for line in file.read_text().splitlines():
        field = _FIELD.match(line)
        if line.startswith("#"):
            notes.append(line.lstrip("# "))
        elif field:
            kind, name, value, meaning = field.groups()
            rows.append(f"| `{name}{' ' + value if value else ''}` | {kind} | {meaning or ''} |")
    return "\n".join(["\n".join(notes), "", *rows]) + "\n"


if __name__ == "__main__":
    path = Path(sys.argv[1])
    path.write_text(document(path.read_text(), path.resolve().parents[2] / "src" / "vsa_msgs" / "msg"))
