"""YAML text: the scalars of YAML 1.2, what is refused, and where it stands."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from roughbench.spec.reading import MAX_CHARACTERS, Place, read_yaml
from roughbench.spec.tree import MAX_DEPTH, render
from roughbench.spec.yaml12 import dump
from roughbench.text import unsafe_character


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e5", 1e5),
        ("1E-3", 1e-3),
        ("1.0e5", 1e5),
        ("1e-5", 1e-5),
        ("-1e+2", -100.0),
        ("+.5", 0.5),
        ("1.", 1.0),
        ("0.1", 0.1),
        ("010", 10),
        ("0o10", 8),
        ("0x1F", 31),
        ("-7", -7),
        ("+7", 7),
        ("12:30:45", "12:30:45"),
        ("2013-01-01", "2013-01-01"),
        ("1_000", "1_000"),
        ("0b1", "0b1"),
        ("1e", "1e"),
        ("e5", "e5"),
        (".", "."),
        ("=", "="),
        ("yes", "yes"),
        ("no", "no"),
        ("on", "on"),
        ("off", "off"),
        ("y", "y"),
        ("true", True),
        ("False", False),
        ("TRUE", True),
        ("null", None),
        ("~", None),
        ("", None),
        ("'1e5'", "1e5"),
        ('"true"', "true"),
        ("'<<'", "<<"),
    ],
)
def test_scalars_are_those_of_yaml_1_2(text: str, value: object) -> None:
    document = read_yaml(f"key: {text}")
    assert document.faults == []
    assert document.tree == {"key": value}
    assert type(document.tree["key"]) is type(value)


def told(text: str) -> list[str]:
    return [
        f"{fault.place.line}:{fault.place.column} {render(fault.path)}: {fault.message}"
        for fault in read_yaml(text).faults
    ]


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("a: &x 1\n", "1:4 a: anchors are not supported; remove &x"),
        (
            "a: 1\nb:\n  - *x\n",
            "3:5 b[0]: aliases are not supported; write the value of *x again",
        ),
        ("a: !!float 1\n", "1:4 a: tags are not supported; remove 'tag:yaml.org,2002:float'"),
        ("a: ! 1\n", "1:4 a: tags are not supported; remove '!'"),
        (
            "a: !!python/object:os.system {}\n",
            "1:4 a: tags are not supported; remove 'tag:yaml.org,2002:python/object:os.system'",
        ),
        ("!x a: 1\n", "1:1 a: tags are not supported; remove '!x'"),
        ("a:\n  H: 1\n  H: 2\n", "3:3 a.H: duplicate key (first on line 2)"),
        ("1: a\n'1': b\n", "2:1 1: duplicate key (first on line 1)"),
        ("<<: {a: 1}\n", "1:1 : merge keys are not supported; write the keys out"),
        ("a: 1\n? [b]\n: 2\n", "2:3 : a key must be a word"),
        ("'': 1\n", "1:1 : a key is missing before ':'"),
        ("a: 1\n---\nb: 2\n", "2:1 : a spec is one YAML document; remove what follows '---'"),
        ("a: .inf\n", "1:4 a: must be a finite number, got .inf"),
        ("a: -.INF\n", "1:4 a: must be a finite number, got -.INF"),
        ("a: .nan\n", "1:4 a: must be a finite number, got .nan"),
        ("a: 1e999\n", "1:4 a: must be a finite number, got 1e999"),
        ("a: -0.1e-400\n", "1:4 a: must be 0 or at least 5e-324 in size, got -0.1e-400"),
        (f"a: {2**63}\n", f"1:4 a: must be an integer below 2**63, got {2**63}"),
        (f"a: {'9' * 5000}\n", f"1:4 a: must be an integer below 2**63, got {'9' * 40}"),
        ('a: "\\uD800"\n', "1:4 a: holds the half character U+D800; remove it"),
        ("a: 1\nb: \x07\n", "2:4 : holds the control character U+0007; remove it"),
        (
            "a:\n\t- 1\n",
            (
                "2:1 : is no valid YAML: found character '\\t' that cannot start any token "
                "(indent with spaces)"
            ),
        ),
        (
            "a: b: c\n",
            (
                "1:5 : is no valid YAML: mapping values are not allowed here "
                "(check the indentation, and quote text that holds ': ')"
            ),
        ),
        (
            "a: 1\nb\n",
            (
                "3:1 : is no valid YAML: could not find expected ':' "
                "(every line of a mapping reads `key: value`)"
            ),
        ),
        (
            "a: 1\n b: 1\n",
            (
                "2:3 : is no valid YAML: mapping values are not allowed here "
                "(check the indentation, and quote text that holds ': ')"
            ),
        ),
        (
            "a: [1\nb: 2\n",
            (
                "2:2 : is no valid YAML: expected ',' or ']', but got ':' "
                "(close the bracket, or put a comma before this)"
            ),
        ),
        (
            "a:\n  b: 1\n c: 1\n",
            (
                "3:2 : is no valid YAML: expected <block end>, but found "
                "'<block mapping start>' (check the indentation of this line against the "
                "one above)"
            ),
        ),
        (
            "a: 'b\n",
            "2:1 : is no valid YAML: found unexpected end of stream (close the quote)",
        ),
        (
            "a: @b\n",
            (
                "1:4 : is no valid YAML: found character '@' that cannot start any token "
                "(quote text that starts with a sign)"
            ),
        ),
    ],
)
def test_what_is_no_plain_yaml_is_refused_with_its_place(text: str, fault: str) -> None:
    assert told(text) == [fault]


def test_an_escape_beyond_unicode_is_no_crash() -> None:
    [fault] = told('a: "\\UFFFFFFFF"\n')
    assert fault.startswith("1:")
    assert "is no valid YAML" in fault


def test_all_structural_faults_are_told_at_once() -> None:
    assert told("a: &x 1\nb: *x\na: 2\nc: .nan\n") == [
        "1:4 a: anchors are not supported; remove &x",
        "2:4 b: aliases are not supported; write the value of *x again",
        "3:1 a: duplicate key (first on line 1)",
        "4:4 c: must be a finite number, got .nan",
    ]


def test_a_duplicate_leaves_the_first_value_and_its_places() -> None:
    document = read_yaml("a: {b: 1}\na: {b: 2}\n")
    assert document.tree == {"a": {"b": 1}}
    assert document.keys["a", "b"] == Place(1, 5)
    assert document.values["a", "b"] == Place(1, 8)


def test_an_alias_bomb_stays_small() -> None:
    bomb = "a0: &a0 [x, x]\n" + "".join(
        f"a{i}: &a{i} [*a{i - 1}, *a{i - 1}, *a{i - 1}]\n" for i in range(1, 40)
    )
    document = read_yaml(bomb)
    assert document.tree["a39"] == [None, None, None]
    assert len(document.faults) == 40 + 3 * 39


def test_depth_is_capped() -> None:
    deepest = "[" * MAX_DEPTH + "]" * MAX_DEPTH
    assert told(f"a: {deepest[1:-1]}") == []
    assert told("a: " + "[" * 100_000) == [
        f"1:{MAX_DEPTH + 4} a[0][0]: is nested deeper than {MAX_DEPTH} levels"
    ]


def test_length_is_capped() -> None:
    assert told("#" * MAX_CHARACTERS) == []
    assert told("#" * (MAX_CHARACTERS + 1)) == [
        f"1:1 : is longer than {MAX_CHARACTERS} characters; a spec is a short text"
    ]


def test_places_are_those_of_keys_and_values() -> None:
    document = read_yaml("surface:\n  H:   0.7\nmodels:\n  - {kind: bem}\n  - kind: persson\n")
    assert document.keys["surface",] == Place(1, 1)
    assert document.keys["surface", "H"] == Place(2, 3)
    assert document.values["surface", "H"] == Place(2, 8)
    assert document.values["models", 0] == Place(4, 5)
    assert document.values["models", 0, "kind"] == Place(4, 12)
    assert document.keys["models", 1, "kind"] == Place(5, 5)


@given(st.text())
def test_no_text_makes_the_reader_crash(text: str) -> None:
    document = read_yaml(text)
    assert document.complete or document.faults


YAML_LIKE = st.text(
    st.sampled_from(list("ab01.:-_ \n[]{},&*!|>'\"#%@`?<~e+\t\\ux")), max_size=60
)


@given(YAML_LIKE)
def test_no_text_of_yaml_signs_makes_the_reader_crash(text: str) -> None:
    document = read_yaml(text)
    assert document.complete or document.faults


PRINTING = st.characters(codec="utf-8").filter(lambda letter: not unsafe_character(letter))
SCALARS = (
    st.none()
    | st.booleans()
    | st.integers(-(2**63) + 1, 2**63 - 1)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(PRINTING, max_size=20)
    | st.sampled_from(["1e5", "010", "no", "null", "1_0", "12:30:45", "<<", "=", ".inf", "0o7"])
)
KEYS = st.text(PRINTING, min_size=1, max_size=10).filter(str.strip)
TREES = st.recursive(
    SCALARS,
    lambda node: st.lists(node, max_size=3) | st.dictionaries(KEYS, node, max_size=3),
    max_leaves=8,
)


@given(st.dictionaries(KEYS, TREES, min_size=1, max_size=4))
def test_what_is_written_reads_back_to_the_last_bit(tree: dict[str, Any]) -> None:
    document = read_yaml(dump(tree))
    assert document.faults == []
    assert document.tree == tree
    assert same_types(document.tree, tree)


def same_types(left: Any, right: Any) -> bool:
    if isinstance(left, dict):
        return all(same_types(left[key], right[key]) for key in left)
    if isinstance(left, list):
        return all(same_types(a, b) for a, b in zip(left, right, strict=True))
    if isinstance(left, float):
        return type(right) is float and math.copysign(1, left) == math.copysign(1, right)
    return type(left) is type(right)
