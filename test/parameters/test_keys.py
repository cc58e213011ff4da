"""Keys are written in one place, and say what physics says."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import flex_ident
from flex_ident.effects import CATALOGUE, key_named
from flex_ident.errors import ConfigurationError
from flex_ident.parameters import FLEXIBLE_KEYS, MEASUREMENT_UNITS, RIGID_KEYS
from flex_ident.parameters.keys import effect_in, key_parts, key_text

ROOT = Path(flex_ident.__file__).parent
CORE = (
    "parameters", "regression", "simulation", "effects", "likelihood", "screening", "estimation", "gap", "pooling",
    "virtual_joint",
)  # fmt: skip
WRITTEN = (
    *FLEXIBLE_KEYS,
    *MEASUREMENT_UNITS,
    *(f"{e.name}.{p.name}" for e in CATALOGUE.values() for p in e.parameters),
)


@pytest.mark.parametrize("text", WRITTEN)
def test_a_key_is_written_as_it_is_read(text: str) -> None:
    key = key_named(text)
    assert str(key) == text == key_text(*key_parts(text))
    assert key.effect == effect_in(text)
    assert key.lower < key.upper


def test_the_side_of_friction_depends_on_the_spring() -> None:
    assert {str(key_named(text, rigid=True)) for text in RIGID_KEYS} == set(RIGID_KEYS)
    assert [key_named("FV", rigid=rigid).side for rigid in (False, True)] == ["link", "motor"]
    assert [key_named("MX", rigid=rigid).side for rigid in (False, True)] == ["link", "link"]
    assert key_named("J").logarithmic
    assert not key_named("FV").logarithmic


@pytest.mark.parametrize("text", ["k", "", "gremlins.size", "backlash.gapp", "backlash"])
def test_a_key_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(ConfigurationError, match="unknown"):
        key_named(text)


def ends_of_sentences(tree: ast.AST) -> Iterator[ast.AST]:
    """Strings that are the last of a formatted string or of a sum: there a point ends a sentence."""
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            yield node.values[-1]
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
            yield node.right


def test_no_other_module_of_the_core_takes_keys_apart() -> None:
    for path in (p for folder in CORE for p in (ROOT / folder).rglob("*.py") if p != ROOT / "parameters" / "keys.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        ends = {id(node) for node in ends_of_sentences(tree)}
        points = [n for n in ast.walk(tree) if isinstance(n, ast.Constant) and n.value == "."]
        assert not [n.lineno for n in points if id(n) not in ends], path
