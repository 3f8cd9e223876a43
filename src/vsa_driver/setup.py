from glob import glob

from setuptools import find_packages, setup

package_name = "vsa_driver"

setup(
    name=package_name,
    version="0.1.0",
    packages=find_packages(),
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package_name}"]),
        (f"share/{package_name}", ["package.xml"]),
        (f"share/{package_name}/config", glob("config/*")),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    maintainer="VSA maintainers",
    maintainer_email="maintainers@example.com",
    description="CAN bus to force and encoder topics, motor commands to CAN, and a simulated rig.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "driver = vsa_driver.driver:main",
            "rig_simulator = vsa_driver.rig_simulator:main",
            "calibrate = vsa_driver.calibrate:main",
        ],
    },
)
