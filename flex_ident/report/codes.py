"""Every notice code with its severity, its meaning and what to do: for a terminal, and as docs/codes.md."""

from __future__ import annotations

import textwrap

from flex_ident.notices import Code

EFFECT = {"info": "leaves the verdict as it is", "doubt": "doubtful at best", "reject": "rejected"}
"""What each severity does to the verdict."""
PAGE_HEAD = """\
# Notice codes

Made by `flex_ident codes --markdown`. Each entry of `warnings` in `result.json` and `gap.json` has a `code`, a
`message`, the `subject` that it is about (a parameter, a signal, a topic) and its `numbers`. Codes stay, messages may
change: script against the former.

`info` leaves the verdict as it is, `doubt` makes it doubtful at best, `reject` rejects.

| code | severity | meaning | what to do |
| --- | --- | --- | --- |
"""


def codes_text() -> str:
    """All codes for a terminal."""
    return "\n\n".join(_entry(code) for code in Code)


def codes_page() -> str:
    """The content of docs/codes.md."""
    rows = (f"| `{c}` | {c.severity} | {c.meaning} | {c.advice} |" for c in Code)
    return PAGE_HEAD + "\n".join(rows) + "\n"


def _entry(code: Code) -> str:
    lines = [f"{code}  ({code.severity}: {EFFECT[code.severity]})"]
    for text in (code.meaning, f"What to do: {code.advice}" if code.advice else ""):
        lines += textwrap.wrap(text, 110, initial_indent="  ", subsequent_indent="  ")
    return "\n".join(lines)
