"""JSON report, for programs."""

import json
from collections.abc import Sequence
from typing import Any

from ..outcome import Outcome
from .run_facts import RunFacts, count_statuses


def format_json(outcomes: Sequence[Outcome], facts: RunFacts) -> bytes:
    """Return the report as JSON: the facts of the run, and a record per picture in the order of the models."""
    document = {
        "version": facts.version,
        "adapter": facts.adapter,
        "began": facts.began,
        "time_s": round(facts.time_s, 6),
        "exit_code": facts.exit_code,
        "reference_threshold": facts.threshold,
        "counts": count_statuses(outcomes),
        "pictures": [_record(outcome) for outcome in outcomes],
        "unused_references": list(facts.unused),
    }
    return (json.dumps(document, indent=1, ensure_ascii=True) + "\n").encode()


def _record(outcome: Outcome) -> dict[str, Any]:
    picture, numbers = outcome.picture, outcome.numbers
    return {
        "models": list(picture.models),
        "status": outcome.status,
        "exit_code": outcome.exit_code,
        "message": outcome.message or None,
        "picture": None if outcome.status == "failed" else picture.output,
        "reference": picture.reference,
        "difference": picture.difference if outcome.status in ("differs", "updated") and numbers is not None else None,
        "different_pixels": None if numbers is None else numbers.n_pixels,
        "allowed_pixels": None if numbers is None else numbers.n_allowed,
        "largest_difference": None if numbers is None else numbers.largest,
        "largest_at": None if numbers is None else list(numbers.largest_at),
        "mean_difference": None if numbers is None else round(numbers.mean, 6),
        "time_s": round(outcome.time_s, 6),
    }
