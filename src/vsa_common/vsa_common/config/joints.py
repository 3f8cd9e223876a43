"""Which joints a process serves: said by the parameter files alone, one namespace a joint."""

from collections.abc import Sequence

from vsa_common.config.configuration import parameter_files, read_parameter_file

DEFAULT = "vsa"


def joints(arguments: Sequence[str], node: str = "driver") -> list[str]:
    """Namespaces in which a parameter file of the ROS `arguments` names `node`, in the order of the files.

    `/left/driver` and `/right/driver` are two joints; what both share can stand under `/**/driver`. A file that
    names no namespace describes one joint, `vsa`. `-r __ns:=/left` picks one of several.
    Raises ConfigurationError for a file that cannot be read.
    """
    if any("__ns:=" in argument for argument in arguments):
        return [DEFAULT]  # which ROS calls otherwise
    found: dict[str, None] = {}
    for path in parameter_files(arguments):
        for key in read_parameter_file(path):
            namespace, _, name = str(key).strip("/").rpartition("/")
            if name == node and namespace and "*" not in namespace:
                found[namespace] = None
    return list(found) or [DEFAULT]
