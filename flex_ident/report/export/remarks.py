"""What the formats that have room for comments say above the model."""

from __future__ import annotations

from flex_ident.effects import told_key
from flex_ident.parameters.keys import effect_in
from flex_ident.report.stored import StoredResult


def remarks(result: StoredResult, *texts: str, held: tuple[str, ...] = ()) -> str:
    """An XML comment: the verdict, what the recording does not determine, the texts, the effects left out."""
    weak = [p.key for p in result.parameters if not p.identifiable]
    left_out = [p.key for p in result.parameters if effect_in(p.key) is not None and p.key not in held]
    effects = dict.fromkeys(map(told_key, left_out))
    lines = [
        f"{result.joint}: {result.verdict}, from {result.path.name} of flex_ident.",
        *([f"Not determined by the recording, do not rely on: {', '.join(weak)}."] if weak else []),
        *([f"Left out, there being no such thing here: {', '.join(effects)}."] if effects else []),
        *texts,
    ]
    return "<!-- " + "\n     ".join(lines).replace("--", "- -") + " -->"
