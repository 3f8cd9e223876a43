from setuptools import find_packages, setup

setup(
    name="vsa_estimator",
    version="0.1.0",
    packages=find_packages(include=["vsa_estimator"]),
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/vsa_estimator"]),
        ("share/vsa_estimator", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    maintainer="VSA maintainers",
    maintainer_email="maintainers@example.com",
    description="Live impedance of one exponential-spring transmission, its identification and its noise.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "estimator = vsa_estimator.node:main",
            "replay = vsa_estimator.replay:main",
            "identify = vsa_estimator.identify:main",
            "noise = vsa_estimator.noise:main",
        ],
    },
)
