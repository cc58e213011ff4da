"""Every code has advice and a sentence, every notice that the package builds can be rendered, and the docs agree."""

import ast
import json
import string
from pathlib import Path

import pytest

import flex_ident
from flex_ident.commands.flex_ident import main
from flex_ident.notices import Code, Notice
from flex_ident.notices.codes import CASES
from flex_ident.report.advice import DOUBTS, REFUSALS, SIGNALS_FIRST
from flex_ident.report.codes import codes_page
from flex_ident.report.sentences import SENTENCES, sentence, warning_content

ROOT = Path(flex_ident.__file__).parent
DOCS = ROOT.parent / "docs" / "codes.md"
BUILT = [
    (path.relative_to(ROOT), call)
    for path in sorted(ROOT.rglob("*.py"))
    for call in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "Notice"
]
"""Every place that builds a notice."""
WORDED = (ROOT / "notices" / "codes.py", ROOT / "report" / "sentences.py", ROOT / "judgement" / "priorities.py")
DECIDED = {
    node.attr
    for path in ROOT.rglob("*.py") if path not in WORDED
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.Attribute)
}  # fmt: skip
"""Every attribute that is named elsewhere, codes among them."""


def test_the_places_that_build_notices_are_found() -> None:
    assert len(BUILT) > 40


@pytest.mark.parametrize("code", Code)
def test_a_code_has_meaning_and_sentence_and_advice_where_it_doubts(code: Code) -> None:
    assert code.severity in ("info", "doubt", "reject")
    assert code.meaning.endswith(".")
    assert code.advice.endswith(".") or (code.severity == "info" and not code.advice)
    assert code in SENTENCES


@pytest.mark.parametrize("code", Code)
def test_a_code_is_one_that_a_result_may_carry(code: Code) -> None:
    """Not one that is documented and never said: it is named where something is decided, not where it is worded."""
    assert code.name in DECIDED


@pytest.mark.parametrize("code", [c for c in Code if c.severity != "info"])
def test_what_doubts_or_rejects_is_said_first(code: Code) -> None:
    assert code in (*SIGNALS_FIRST, *DOUBTS, *REFUSALS)


def test_a_case_may_be_worse_than_its_code() -> None:
    slow, fast = (Notice(Code.HELD_SAMPLES, "/t:a", texts={"case": case}) for case in ("slow", "fast"))
    assert (slow.severity, fast.severity, Code.HELD_SAMPLES.severity) == ("doubt", "info", "info")
    for (code, case), severity in CASES.items():
        known = SENTENCES[code]
        assert not isinstance(known, str)
        assert case in known  # type: ignore[operator]
        assert code in (*SIGNALS_FIRST, *DOUBTS, *REFUSALS)
        assert f"{severity}s where" in code.meaning


@pytest.mark.parametrize(("path", "call"), BUILT, ids=[f"{p}:{c.lineno}" for p, c in BUILT])
def test_a_notice_names_its_code_by_the_enum(path: Path, call: ast.Call) -> None:
    code = call.args[0]
    if isinstance(code, ast.Attribute):
        assert isinstance(code.value, ast.Name), path
        assert code.value.id == "Code", path
        assert code.attr in Code.__members__, path
    else:  # a code looked up in a table
        assert not isinstance(code, ast.Constant), path


@pytest.mark.parametrize("code", Code)
def test_every_sentence_of_a_code_can_be_made(code: Code) -> None:
    """With the fields that its template names, or that the functions ask for."""
    known = SENTENCES[code]
    cases = dict(known) if not isinstance(known, str) and not callable(known) else {"": known}
    for case, template in cases.items():
        asked = _fields(template) if isinstance(template, str) else FIELDS[code]
        texts = {"case": case, "unit": "N m"} if case else {"unit": "N m"}
        numbers = {}
        for name, kind in asked.items():
            if kind == "s":
                texts.setdefault(name, "this")
            else:
                numbers[name] = 2.0
        said = sentence(Notice(code, "K", numbers, texts))
        assert said[:1]
        assert "{" not in said


FIELDS: dict[Code, dict[str, str]] = {
    Code.TIME_JUMPED_BACK: dict.fromkeys(("jumps", "largest_s", "at_s", "kept", "dropped"), "f"),
    Code.CLOCK_STEPPED: dict.fromkeys(("steps", "largest_ms"), "f"),
    Code.CLOCK_DRIFT: dict.fromkeys(("ppm", "std_ppm", "total_ms"), "f"),
    Code.ISOLATED_VALUES: dict.fromkeys(("count", "total", "constant"), "f"),
    Code.EFFORT_FROZEN: dict.fromkeys(("stretches", "seconds", "count", "total"), "f"),
    Code.POSITION_UNWRAPPED: dict.fromkeys(("jumps", "size"), "f"),
    Code.POSITION_REZEROED: dict.fromkeys(("jumps", "largest"), "f"),
    Code.POSITION_NOT_SI: {"ratio": "f"},
    Code.NOT_IDENTIFIABLE: {"std": "f"},
    Code.LOW_EXCITATION: {"relative_std_percent": "f"},
    Code.CAUSE_SUSPECTED: {"moved_stds": "f"},
    Code.TORQUE_DELAY: {"delay_s": "f", "sample_s": "f"},
    Code.LINK_SKEW: {"delay_s": "f", "sample_s": "f"},
    Code.OTHER_JOINTS_MOVE: {"count": "f", "joints": "s"},
    Code.CHAIN_AT_ITS_END: {"value": "f"},
    Code.MOTOR_EQUATION: dict.fromkeys(("K", "std", "left_percent", "least_skew_s"), "f"),
    Code.BASE_NOT_DETERMINED: {"effects": "s"},
    Code.FEW_RECORDINGS: {"count": "f"},
    Code.FEW_SESSIONS: {"count": "f", "recordings": "f"},
    Code.TORQUE_SCALE: dict.fromkeys(("scale", "two_std", "angle_deg", "least_deg", "inertia", "weight"), "f"),
}
"""What the sentences that are functions ask for."""


def _fields(template: str) -> dict[str, str]:
    """Names in a format string, `f` for numbers and `s` for texts."""
    named = [(name, form) for _, name, form, _ in string.Formatter().parse(template) if name not in (None, "subject")]
    return {str(name): "f" if form else "s" for name, form in named}


@pytest.mark.parametrize(("path", "call"), BUILT, ids=[f"{p}:{c.lineno}" for p, c in BUILT])
def test_a_notice_brings_what_its_sentence_needs(path: Path, call: ast.Call) -> None:
    """Wherever the code is named; a case that is chosen at run time must have all that any of its sentences needs."""
    given = dict(zip(("code", "subject", "numbers", "texts"), call.args, strict=False))
    given |= {k.arg: k.value for k in call.keywords if k.arg}
    code = given["code"]
    if not isinstance(code, ast.Attribute):
        pytest.skip("its code is looked up in a table")
    numbers, texts = (_written(given.get(name), path, call.lineno) for name in ("numbers", "texts"))
    known = SENTENCES[Code[code.attr]]
    if isinstance(known, str) or callable(known):
        templates = [known]
    else:
        case = texts.get("case", ast.Constant(""))
        templates = [known[case.value]] if isinstance(case, ast.Constant) else list(known.values())
    for template in templates:
        asked = _fields(template) if isinstance(template, str) else FIELDS[Code[code.attr]]
        assert set(asked) <= {*numbers, *texts}, f"{path}:{call.lineno}"


def _written(node: ast.expr | None, path: Path, line: int) -> dict[str, ast.expr]:
    """The dict that a call is given: in place, or under a name that was last set above it."""
    if isinstance(node, ast.Name):
        tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
        above = [n for n in ast.walk(tree) if isinstance(n, ast.Assign) and n.lineno < line and _sets(n, node.id)]
        node = max(above, key=lambda n: n.lineno).value
    if node is None:
        return {}
    assert isinstance(node, ast.Dict), f"{path}:{line}"
    return {ast.literal_eval(k): v for k, v in zip(node.keys, node.values, strict=True) if k}


def _sets(node: ast.Assign, name: str) -> bool:
    return isinstance(node.targets[0], ast.Name) and node.targets[0].id == name


def test_no_decision_looks_for_words_in_a_sentence() -> None:
    """A sentence is printed, never searched: `in`, `startswith` and the like do not meet `sentence(...)`."""
    for path in ROOT.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
                asked = node.func.attr in ("startswith", "endswith", "find", "index", "count", "split")
                assert not (asked and _is_sentence(node.func.value)), path
            if isinstance(node, ast.Compare) and any(isinstance(o, ast.In | ast.NotIn) for o in node.ops):
                assert not any(map(_is_sentence, node.comparators)), path


def _is_sentence(node: ast.AST) -> bool:
    return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "sentence"


def test_a_code_that_is_none_is_refused() -> None:
    with pytest.raises(ValueError, match="no_such_code"):
        Notice("no_such_code")  # type: ignore[arg-type]
    assert Notice("gaps").code is Code.GAPS  # type: ignore[arg-type]


def test_equal_notices_are_one() -> None:
    one, other = (Notice(Code.BAG_DAMAGED, "/a", {"count": n}, {"case": "messages"}) for n in (1, 2))
    assert len(dict.fromkeys([one, other, one])) == 2


def test_a_warning_in_json_has_code_message_subject_and_numbers() -> None:
    content = warning_content(Notice(Code.NOT_IDENTIFIABLE, "K", {"std": float("inf")}, {"unit": "N m/rad"}))
    assert json.loads(json.dumps(content, allow_nan=False)) == {
        "code": "not_identifiable", "subject": "K", "numbers": {"std": None},
        "message": "K is not determined by this recording (not at all): sweep through the resonance with a larger "
        "amplitude, with a payload, or read a link encoder.",
    }  # fmt: skip


def test_the_docs_list_the_codes() -> None:
    assert DOCS.read_text(encoding="utf-8") == codes_page(), "flex_ident codes --markdown > docs/codes.md"


def test_the_command_prints_every_code(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["codes"]) == 0
    said = capsys.readouterr().out
    for code in Code:
        assert f"{code}  ({code.severity}" in said
    assert main(["codes", "--markdown"]) == 0
    assert capsys.readouterr().out == codes_page()
