# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Dockerfiles, devcontainer and workflow: their commands, and what of them runs without containers."""

import json
import re
import subprocess

import pytest
import yaml
from emulated_machine import ROOT
from vsa_tools.demo.isolation import claim_domain

WORKFLOW = yaml.safe_load((ROOT / ".github" / "workflows" / "ci.yml").read_text())
DOCKERFILES = sorted((ROOT / "docker").glob("*.Dockerfile"))
INSTALLATION = (ROOT / "docs" / "tutorials" / "install.md").read_text()
ROSDEP = re.compile(r"rosdep install --from-paths \S+ (.*?)(?:\s*\\)?$", re.MULTILINE)


def scripts():
    """Commands of every step of the workflow."""
    steps = [(name, step) for name, job in WORKFLOW["jobs"].items() for step in job["steps"] if "run" in step]
    return {f"{name}: {step.get('name', step['run'])}": step["run"] for name, step in steps}


@pytest.mark.parametrize("name", scripts())
def test_every_step_of_the_workflow_is_a_valid_script(name):
    subprocess.run(["bash", "-n"], input=scripts()[name], text=True, check=True)


@pytest.mark.parametrize("name", ["entrypoint.sh", *(f"../.ci/{one}" for one in ("run", "await_joint", "simulated"))])
def test_every_script_is_valid_and_executable(name):
    path = ROOT / "docker" / name
    subprocess.run(["bash", "-n", path], check=True)
    assert path.stat().st_mode & 0o100


def test_every_file_of_the_workflow_exists():
    text = "\n".join(scripts().values())
    assert all((ROOT / ".ci" / name).exists() for name in re.findall(r"\.ci/(\w+)", text))
    assert {f"{name}.Dockerfile" for name in WORKFLOW["jobs"]["containers"]["strategy"]["matrix"]["image"]} == {
        path.name for path in DOCKERFILES
    }


def test_rosdep_has_the_arguments_of_the_documented_command():
    texts = [INSTALLATION, "\n".join(scripts().values()), (ROOT / "docker" / "ros.Dockerfile").read_text()]
    found = [ROSDEP.findall(text) for text in texts]
    assert all(found)
    assert len({arguments for text in found for arguments in text}) == 1


def test_the_devcontainer_builds_a_stage_of_an_existing_dockerfile():
    folder = ROOT / ".devcontainer"
    container = json.loads((folder / "devcontainer.json").read_text())["build"]
    assert f" AS {container['target']}\n" in (folder / container["dockerfile"]).resolve().read_text()
    assert (folder / container["context"]).resolve() == ROOT


@pytest.mark.parametrize("dockerfile", DOCKERFILES, ids=lambda path: path.name)
def test_a_dockerfile_copies_and_runs_existing_files(dockerfile):
    text = dockerfile.read_text()
    for source in re.findall(r"^COPY (\S+) ", text, re.MULTILINE):
        assert (ROOT / source).exists()
    for path in re.findall(r"/vsa/([\w./]+)\"", text):
        assert (ROOT / path).exists()


@pytest.mark.live
def test_the_smoke_test_of_the_workflow_ends_with_a_valid_stiffness():
    domain = claim_domain()
    variables = {"RATE_HZ": "200", "BUS_OPTIONS": f"['hop_limit=0','port={domain.bus_port}']"}
    command = [ROOT / ".ci" / "await_joint", ROOT / ".ci" / "simulated"]
    environment = domain.environment() | variables
    result = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=250, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    assert re.search(r"await_joint: \d+\.\d+ N m/rad on /vsa/joint_impedance", result.stdout)


@pytest.mark.live
def test_the_smoke_test_fails_where_no_joint_publishes():
    environment = claim_domain().environment() | {"LIMIT_S": "2"}
    command = [ROOT / ".ci" / "await_joint", "sleep", "60"]
    result = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60, check=False)
    assert result.returncode == 1
    assert "no valid stiffness on /vsa/joint_impedance in 2 s; reasons: no message" in result.stderr
