# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
from xml.etree import ElementTree

from setuptools import find_packages, setup

package = ElementTree.parse("package.xml").getroot()  # name, version and licence stand there alone
name = package.findtext("name")

setup(
    name=name,
    version=package.findtext("version"),
    packages=find_packages(),
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{name}"]),
        (f"share/{name}", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},  # colcon test then runs pytest
    zip_safe=False,
    maintainer=package.findtext("maintainer"),
    maintainer_email=package.find("maintainer").get("email"),
    description=package.findtext("description"),
    license=package.findtext("license"),
    entry_points={
        "console_scripts": [
            "joint = vsa_joint.node:main",
            "stiffness_controller = vsa_joint.controller_node:main",
            "excitation = vsa_joint.excitation_node:main",
            "excite = vsa_joint.cli.excite:main",
        ],
    },
)
