from setuptools import find_packages, setup

setup(
    name="vsa_joint",
    version="0.1.0",
    packages=find_packages(include=["vsa_joint"]),
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/vsa_joint"]),
        ("share/vsa_joint", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    maintainer="VSA maintainers",
    maintainer_email="maintainers@example.com",
    description="Joint impedance from two transmissions, and stiffness control.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "joint = vsa_joint.joint:main",
            "stiffness_controller = vsa_joint.stiffness_controller:main",
        ],
    },
)
