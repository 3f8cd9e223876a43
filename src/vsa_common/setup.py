from setuptools import find_packages, setup

package_name = "vsa_common"

setup(
    name=package_name,
    version="0.1.0",
    packages=find_packages(),
    package_data={package_name: ["*.xml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package_name}"]),
        (f"share/{package_name}", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    extras_require={"test": ["pytest"]},
    zip_safe=True,
    maintainer="VSA maintainers",
    maintainer_email="maintainers@example.com",
    description="What every node of the suite shares.",
    license="Apache-2.0",
)
