"""What the formats that have room for comments say above the model."""

from __future__ import annotations

from flex_ident.effects import CATALOGUE
from flex_ident.parameters.keys import effect_in
from flex_ident.report.stored import StoredResult


def _named(key: str) -> str:
    """An effect's parameter by its key; of one that is a table, the whole of it."""
    effect = effect_in(key)
    known = CATALOGUE.get(effect or "")
    return f"{effect} (a table)" if known is not None and known.curve is not None else key


def remarks(result: StoredResult, *texts: str, held: tuple[str, ...] = ()) -> str:
    """An XML comment: the verdict, what the recording does not determine, the texts, the effects left out."""
    weak = [p.key for p in result.parameters if not p.identifiable]
    effects = list(dict.fromkeys(_named(p.key) for p in result.parameters if "." in p.key and p.key not in held))
    lines = [
        f"{result.joint}: {result.verdict}, from {result.path.name} of flex_ident.",
        *([f"Not determined by the recording, do not rely on: {', '.join(weak)}."] if weak else []),
        *([f"Left out, there being no such thing here: {', '.join(effects)}."] if effects else []),
        *texts,
    ]
    return "<!-- " + "\n     ".join(lines).replace("--", "- -") + " -->"
