"""One thing to say about a recording or a result, without a sentence: those are made in `report/sentences.py`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from flex_ident.notices.codes import CASES, Code, Severity


@dataclass(frozen=True)
class Notice:
    """A code, the `subject` it is about (a parameter's key, a signal, a topic, a file), and what fills its sentence.

    `numbers` are in the units that their names carry, else SI; `texts` are names and units, and `case` where one code
    has several sentences. No text is a sentence. Raises ValueError for a code that is none.
    """

    code: Code
    subject: str = ""
    numbers: Mapping[str, float] = field(default_factory=dict, hash=False)
    texts: Mapping[str, str] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "code", Code(self.code))
        object.__setattr__(self, "numbers", {k: float(v) for k, v in self.numbers.items()})
        object.__setattr__(self, "texts", dict(self.texts))

    @property
    def case(self) -> str:
        """Which of its code's sentences this is; empty where there is one only."""
        return self.texts.get("case", "")

    @property
    def severity(self) -> Severity:
        """What it does to the verdict: its code's severity, or that of its case where it is worse."""
        return CASES.get((self.code, self.case), self.code.severity)
