from glob import glob

from setuptools import find_packages, setup

package_name = "vsa_bringup"

setup(
    name=package_name,
    version="0.1.0",
    packages=find_packages(include=[package_name, f"{package_name}.*"]),
    package_data={package_name: ["static/*", "layouts/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package_name}"]),
        (f"share/{package_name}", ["package.xml"]),
        (f"share/{package_name}/config", glob("config/*")),
        (f"share/{package_name}/launch", glob("launch/*.launch.py")),
        (f"share/{package_name}/layouts", glob("layouts/*")),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    maintainer="VSA maintainers",
    maintainer_email="maintainers@example.com",
    description="Launch files, configuration and the user's tools: demo, record, report, view, design, bench.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "demo = vsa_bringup.demo:main",
            "record = vsa_bringup.record:main",
            "report = vsa_bringup.report:main",
            "view = vsa_bringup.view:main",
            "design = vsa_bringup.design:main",
            "bench = vsa_bringup.bench:main",
            "composed = vsa_bringup.composed:main",
        ],
    },
)
