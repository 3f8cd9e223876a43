"""Parameter file of a run: layers of parameters merged over those of paper_rig.yaml."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from ament_index_python.packages import get_package_share_directory
from vsa_common.config.configuration import read_parameter_file
from vsa_tools.demo.start_values import perturbed

Tree = dict[str, Any]
Layer = Mapping[str, Mapping[str, Any]]  # parameters by bare node name
_PARAMETERS = "ros__parameters"


def paper_rig() -> Path:
    """The installed paper_rig.yaml."""
    return Path(get_package_share_directory("vsa_bringup"), "config", "paper_rig.yaml")


def merge(base: Mapping[str, Any], changes: Mapping[str, Any]) -> Tree:
    """`base` with the values of `changes`, section by section.

    >>> merge({"a": {"x": 1, "y": 2}}, {"a": {"y": 3}, "b": 4})
    {'a': {'x': 1, 'y': 3}, 'b': 4}
    """
    merged = dict(base)
    for name, value in changes.items():
        old = merged.get(name)
        merged[name] = merge(old, value) if isinstance(old, Mapping) and isinstance(value, Mapping) else value
    return merged


def base_parameters() -> Layer:
    """The sections of paper_rig.yaml by bare node name."""
    return {key.rsplit("/", 1)[-1]: section[_PARAMETERS] for key, section in read_parameter_file(paper_rig()).items()}


def write_parameters(path: Path, *layers: Layer) -> None:
    """Write layers of parameters, later ones first in precedence, as one parameter file for nodes in any namespace.

    A node name with a leading / applies to that node only.
    """
    merged: Tree = {}
    for layer in layers:
        merged = merge(merged, layer)
    tree = {node if node.startswith("/") else f"/**/{node}": {_PARAMETERS: values} for node, values in merged.items()}
    path.write_text(yaml.dump(tree, Dumper=_Plain, sort_keys=False))


class _Plain(yaml.SafeDumper):
    """Writes no aliases: the parameter parser of ROS does not support them."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def perturbed_initial_values(rig: Mapping[str, Any], seed: int) -> dict[str, dict[str, Any]]:
    """`initial` of both estimators for the rig with parameters `rig`, perturbed at random by `seed`.

    Both rods start at rest, where the forces of the springs balance the external torque.
    """
    first, second = rig["transmission_1"], rig["transmission_2"]
    force = first["force_offset"] + first["k1"] * math.exp(first["k2"] * rig["profile"]["centre"])
    torque_force = 2.0 * rig.get("torque", {}).get("constant", 0.0) / rig["joint"]["radius"]
    generator = np.random.default_rng(seed)
    return {
        f"estimator_{i}": {"initial": perturbed(side, rod_force, generator)}
        for i, (side, rod_force) in enumerate(((first, force), (second, force + torque_force)), 1)
    }
