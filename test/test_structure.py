# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""House rules on size: modules, functions, parameters, folders; the tests mirror the packages."""

import ast

import pytest
from source_tree import PACKAGES, ROOT, dotted, folders, modules, package_root

MODULE_LINES, FUNCTION_LINES, PARAMETERS, POSITIONAL, FOLDER_MODULES = 250, 40, 8, 8, 12


def functions(file):
    tree = ast.parse(file.read_text())
    return [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]


def parameters(function):
    """Names of a function's parameters without self and cls."""
    every = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
    return [one.arg for i, one in enumerate(every) if i or one.arg not in ("self", "cls")]


def name(file, node):
    return f"{dotted(file)}:{node.lineno} {getattr(node, 'name', 'call')}"


@pytest.mark.parametrize("package", PACKAGES)
def test_modules_are_short(package):
    """Without the copyright line."""
    assert [file for file in modules(package) if len(file.read_text().splitlines()) > MODULE_LINES + 1] == []


@pytest.mark.parametrize("package", PACKAGES)
def test_functions_are_short(package):
    every = [(file, one) for file in modules(package) for one in functions(file)]
    assert [name(*one) for one in every if one[1].end_lineno - one[1].lineno >= FUNCTION_LINES] == []


@pytest.mark.parametrize("package", PACKAGES)
def test_functions_have_few_parameters(package):
    every = [(file, one) for file in modules(package) for one in functions(file)]
    assert [name(*one) for one in every if len(parameters(one[1])) > PARAMETERS] == []


@pytest.mark.parametrize("package", PACKAGES)
def test_calls_have_few_positional_arguments(package):
    calls = [
        (file, node)
        for file in modules(package)
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, ast.Call)
    ]
    assert [name(*one) for one in calls if len(one[1].args) > POSITIONAL] == []


@pytest.mark.parametrize("package", PACKAGES)
def test_folders_have_few_modules(package):
    counts = {dotted(folder): len(list(folder.glob("*.py"))) - 1 for folder in folders(package)}
    assert {folder: count for folder, count in counts.items() if count > FOLDER_MODULES} == {}


@pytest.mark.parametrize("package", PACKAGES)
def test_every_folder_of_tests_mirrors_one_of_the_package(package):
    tests = ROOT / "test" / package
    mirrored = {path.relative_to(tests) for path in tests.rglob("*") if path.is_dir() and any(path.glob("*.py"))}
    assert {str(path) for path in mirrored if not (package_root(package) / path).is_dir()} == set()
