# Copyright 2026 the VSA authors. SPDX-License-Identifier: Apache-2.0
"""Identifiers, comments, strings and documents use technical terms: none of WORDS, which are metaphors here.

CHANGELOG.md and docs/decisions name former identifiers and are exempt. A word with a technical meaning in this project
does not belong in WORDS.
"""

import io
import re
import tokenize
from pathlib import Path

import pytest
from source_tree import ROOT

METAPHORS = """
belief beliefs believe believes believed believing disbelief doubt doubts doubted doubtful doubting trust trusts
trusted trusting distrust honest honestly honesty liar liars lied lying pretend pretends pretended pretending pretence
tell tells told telling untold hear hears heard hearing unheard overhear overheard ears deaf deafens deafened
deafening blind blinds blinded blinding say says said saying speak speaks spoke spoken talk talks talked insist
insists insisted insisting complain complains complained complaint complaints witness witnesses witnessed contradict
contradicts contradicted contradiction contradictions suspicious suspicion judge judges judged judging judgement
judgements judgment verdict verdicts heed heeds heeded astray startle startles startled startling surprise surprises
surprised surprising forgive forgives forgiven forgave hurry hurries hurried hurrying coast coasts coasted coasting
learn learns learnt learned learning learner learners unlearn lesson lessons forget forgets forgot forgotten remember
remembers remembered remembering knows feel feels felt feeling wish wishes wished nobody somebody everybody anybody
whoever stranger strangers patience lonely tired bread meat sandwich torsor leap leaps leapt vague vagueness unsure
boldest brisk briskly ragged loud kink kinks haul story stories appraise appraises appraisal appraisals gatherer plate
plates mend mends mended mending happily unhappy angry afraid sick healed heals
"""
WORDS = frozenset(METAPHORS.split())
EXEMPT = {Path("CHANGELOG.md"), Path("test/test_vocabulary.py")}
PARTS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")  # of identifiers: snake case, camel case
SUFFIXES = {".py", ".md", ".msg", ".srv", ".yaml"}
TOKENS = {tokenize.NAME, tokenize.COMMENT, tokenize.STRING, getattr(tokenize, "FSTRING_MIDDLE", -1)}


def checked_files():
    """Files by the folder that is one test; each document on its own."""
    groups = {}
    for top in ("src", "test", "examples", "docs", "README.md", "CONTRIBUTING.md"):
        path = ROOT / top
        for file in sorted(path.rglob("*")) if path.is_dir() else [path] * path.exists():
            name = file.relative_to(ROOT)
            if file.suffix in SUFFIXES and name not in EXEMPT and not {"decisions", "__pycache__"} & {*name.parts}:
                groups.setdefault(str(name if file.suffix == ".md" else name.parent), []).append(file)
    return groups


FILES = checked_files()


def words(text):
    return (part.lower() for part in PARTS.findall(text))


def metaphors(file):
    """(line, word) of each of WORDS in a file."""
    text = file.read_text()
    if file.suffix == ".py":
        tokens = tokenize.generate_tokens(io.StringIO(text).readline)
        file_position = re.compile(r"\.tell\(\)")  # a method of Python's files
        used = (token for token in tokens if token.type in TOKENS)
        parts = [
            (token.start[0], token.string)
            for token in used
            if not (token.string == "tell" and file_position.search(token.line))
        ]
    else:
        parts = list(enumerate(text.splitlines(), 1))
    lines = ((first + i, line) for first, part in parts for i, line in enumerate(part.splitlines()))
    return [(number, word) for number, line in lines for word in words(line) if word in WORDS]


@pytest.mark.parametrize("group", FILES)
def test_no_metaphor_is_used(group):
    found = [f"{file.relative_to(ROOT)}:{line}: {word}" for file in FILES[group] for line, word in metaphors(file)]
    assert not found, "\n" + "\n".join(found)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("_is_believed = 1  # fine\n", [(1, "believed")]),
        ("class SensorLiar: '''one\ntells two'''\n", [(1, "liar"), (2, "tells")]),
        ("WITNESS_AGE = f'{x} heard'  # nobody\n", [(1, "witness"), (1, "heard"), (1, "nobody")]),
        ("tellurium = ignored = 1\n", []),
    ],
)
def test_words_are_found_in_identifiers_strings_and_comments(tmp_path, text, found):
    (tmp_path / "module.py").write_text(text)
    assert metaphors(tmp_path / "module.py") == found
