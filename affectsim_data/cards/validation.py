"""What a report of `affectsim validate` comes to, for a card."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from affectsim_data.cards.markdown import code_span, plain, table

__all__ = ["VALIDATION_NAME", "validation_text"]

VALIDATION_NAME = "validation.parquet"
"""The report, beside the release."""
_COLUMNS = ["kind", "check", "message", "checked", "failures"]


def validation_text(path: Path) -> str:
    """The report as Markdown: a verdict and the checks; empty if there is no report.

    Raises:
        ValueError: The file is no such report.
    """
    if not path.is_file():
        return ""
    try:
        lacking = set(_COLUMNS) - set(pq.read_schema(path).names)
        problem = f"columns {', '.join(sorted(lacking))} are missing" if lacking else ""
    except (pa.ArrowInvalid, OSError) as error:
        problem = str(error)
    if problem:
        raise ValueError(
            f"{path}: not a report of `affectsim validate`: {problem}; delete it, or write it anew "
            "with --report"
        )
    rows = pq.read_table(path, columns=_COLUMNS).to_pylist()
    checks = [row for row in rows if row["kind"] == "check" and row["checked"]]
    failed = [row for row in checks if row["failures"]]
    verdict = (
        f"**{len(failed)} of {len(checks)} checks fail**"
        if failed
        else f"all {len(checks)} checks hold"
    )
    listed = [
        [code_span(row["check"]), plain(row["message"]), row["checked"], row["failures"]]
        for row in [*failed, *(row for row in checks if not row["failures"])]
    ]
    header = ["check", "what is counted or measured", "items", "failed"]
    return (
        f"By `affectsim validate`, from the stored files: {verdict}.\n\n"
        "<details>\n<summary>All checks</summary>\n\n"
        f"{table(header, listed, left=2)}\n\n</details>"
    )
