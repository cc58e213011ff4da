"""A table of all parameters; one column says whether the recording determines each."""

from __future__ import annotations

import csv
import io

from flex_ident.report.stored import StoredResult


def written(result: StoredResult) -> str:
    """One row a parameter: joint, key, value, standard deviation, unit, identifiable."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(("joint", "parameter", "value", "std", "unit", "identifiable"))
    for p in result.parameters:
        writer.writerow((result.joint, p.key, f"{p.value:.9g}", f"{p.std:.4g}", p.unit, p.identifiable))
    return text.getvalue().rstrip()
