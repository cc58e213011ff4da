"""The parameter table, in the form of the paper's Tables 1 to 3, for a terminal."""

from __future__ import annotations

import math
from collections.abc import Sequence

from flex_ident.parameters import Identification, Parameter
from flex_ident.parameters.keys import key_parts
from flex_ident.parameters.parameter import PRISMATIC_UNITS
from flex_ident.report.advice import first_thing, other_things
from flex_ident.report.sentences import sentence

MEANING = {
    "Jm": "motor inertia", "K": "joint stiffness", "JL": "link inertia", "FVm": "motor viscous friction",
    "FSm": "motor Coulomb friction", "FV": "link viscous friction", "FS": "link Coulomb friction",
    "MX": "first moment, x", "MY": "first moment, y", "offset": "constant motor torque", "J": "inertia",
    "torque_delay": "torque recorded late by", "link_skew": "link position late by", "link_zero": "link encoder's zero",
    "link_scale": "link encoder's scale error", "link_drift": "link encoder's clock fast by",
    "torque_averaging": "torque averaging",
}  # fmt: skip


def meaning_of(key: str, *, rigid: bool = False, prismatic: bool = False, alone: bool = False) -> str:
    """What a key stands for, in words; `alone`: seen from the motor alone, where stiffness is of all that yields."""
    if alone and key == "K":
        return "stiffness seen from the motor"
    effect, name = key_parts(key)
    words = MEANING.get(key, f"{effect}: {name}".replace("_", " ") if effect is not None else "")
    if prismatic:
        words = words.replace("inertia", "mass").replace("torque", "force")
    return words.removeprefix("link ") if rigid else words


def percent_text(percent: float) -> str:
    """A share with two digits, or as a whole number from 10 on: '0.52 %', '100 %'; what rounding leaves is '0 %'."""
    if percent < 1e-3:
        return "0 %"
    return f"{percent:.0f} %" if percent >= 10.0 else f"{percent:.2g} %"


def delay_texts(result: Identification) -> list[str]:
    """The delays of a result's measurement chain in words, each with the low-pass that is in it too."""
    prismatic = any(p.unit == PRISMATIC_UNITS.get(p.key) for p in result.parameters)
    lag = next((p.value for p in result.measurement if p.key == "effort_lag"), 0.0)
    return [
        delay_text(p, lag if p.key == "torque_delay" else 0.0, prismatic=prismatic)
        for p in result.measurement if p.key in ("torque_delay", "link_skew") and math.isfinite(p.value)
    ]  # fmt: skip


def delay_text(p: Parameter, lag: float = 0.0, *, prismatic: bool = False) -> str:
    """A delay of the measurement chain, s, in words: 'torque recorded 0.120 ± 0.004 ms late'.

    `lag` is the time, s, of a low-pass in the same signal, which is late by that too.
    """
    if lag > 0.5e-6:  # less would be told as 0.000 ms
        return f"{delay_text(p, prismatic=prismatic)}, behind a low-pass that makes it {1e3 * lag:.3f} ms later"
    what = {"torque_delay": f"{'force' if prismatic else 'torque'} recorded", "link_skew": "link position read"}[p.key]
    side = "late" if p.value >= 0.0 else "early"
    size = f"{1e3 * abs(p.value):.3f}"
    if p.at_bound:
        return f"{what} {size} ms {side}, which is its limit"
    known = f" ± {2e3 * p.std:.2g}" if math.isfinite(p.std) else ""
    return f"{what} {size}{known} ms {side}"


def rounded(value: float, std: float) -> str:
    """A number with two digits of its uncertainty, or four significant ones when that is unknown."""
    if not math.isfinite(value):
        return "-"
    if not math.isfinite(std) or std <= 0.0:
        return f"{value:.4g}"
    decimals = 1 - math.floor(math.log10(std))
    if decimals <= 0:
        return f"{round(value, decimals):.0f}"
    return f"{value:.{decimals}f}" if decimals < 9 else f"{value:.4g}"


def parameter_row(p: Parameter, *, rigid: bool = False, alone: bool = False) -> tuple[str, str, str, str, str, str]:
    """Key, value, 2 sigma, % sigma, unit and meaning of one parameter, as text."""
    value = rounded(p.value, p.std)
    two = rounded(2.0 * p.std, 2.0 * p.std) if math.isfinite(p.std) else "-"
    share = f"{p.relative_std_percent:.2g}" if p.relative_std_percent < 1e4 else "-"
    if p.at_bound:
        two, share = "at bound", "-"
    meaning = meaning_of(p.key, rigid=rigid, prismatic=p.unit == PRISMATIC_UNITS.get(p.key), alone=alone)
    if not p.identifiable:
        meaning = f"{meaning} (not identifiable)".strip()
    return p.key, value, two, share, p.unit, meaning


def text_table(header: Sequence[str], rows: Sequence[Sequence[str]], *, right: Sequence[int] = ()) -> str:
    """Rows in columns, two spaces apart; columns in `right` flush right."""
    widths = [max(len(str(r[i])) for r in (header, *rows)) for i in range(len(header))]
    lines = []
    for k, row in enumerate((header, *rows)):
        cells = [c.rjust(w) if i in right else c.ljust(w) for i, (c, w) in enumerate(zip(row, widths, strict=True))]
        lines.append("  ".join(cells).rstrip())
        if k == 0:
            lines.append("  ".join("-" * w for w in widths))
    return "\n".join(lines)


def result_text(result: Identification) -> str:
    """The result for a person at a terminal: verdict, table, modes, errors, warnings."""
    lines = [f"{result.joint}: {result.verdict}  (sensors {result.sensors}, method {result.method})", ""]
    header = ("parameter", "value", "± 2σ", "%σ", "unit", "")
    rigid, alone = result.model.rigid, result.sensors == "motor"
    rows = [parameter_row(p, rigid=rigid, alone=alone) for p in result.parameters]
    lines.append(text_table(header, rows, right=(1, 2, 3)))
    if result.combined:
        lines += ["", text_table(header, [parameter_row(p) for p in result.combined], right=(1, 2, 3))]
    lines.append("")
    if "locked_motor_hz" in result.derived and result.verdict != "rejected":
        free = result.derived.get("free_resonance_hz")
        more = "" if free is None else f", free {free:.4g} Hz"
        lines.append(f"modes: locked motor {result.derived['locked_motor_hz']:.4g} Hz{more}")
    if "x5_sigmas" in result.derived:
        lines.append(
            f"X5: {result.combined[4].value:.4g} fitted, {result.derived['x5_predicted']:.4g} from the other six: "
            f"{result.derived['x5_sigmas']:.1f} standard deviations apart"
        )
    fit = result.fit
    prismatic = any(p.unit == PRISMATIC_UNITS.get(p.key) for p in result.parameters)
    unseen = fit.validation_relative_error_percent
    lines.append(
        f"{'force' if prismatic else 'torque'} error: {fit.relative_error_percent:.2f} %, on data not fitted "
        f"{f'{unseen:.2f} %' if math.isfinite(unseen) else 'unknown'}; condition number {fit.condition_number:.3g}"
    )
    lines += [f"measurement: {text}, corrected for" for text in delay_texts(result)]
    if result.verdict != "rejected":
        return "\n".join([*lines, *(f"warning: {sentence(n)}" for n in result.notices)])
    first = first_thing(result)
    lines += [f"to do first: {first}"] if first else []
    return "\n".join([*lines, *(f"warning: {text}" for text in other_things(result) if text != first)])
