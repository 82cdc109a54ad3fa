"""Suggestions for misspelt words."""

from collections.abc import Iterable

# From 0 to 1: --width resembles --line-width, --angle does not resemble --scale; "nan" does not resemble "tan".
MIN_OPTION_SIMILARITY = 0.65
MIN_FILE_TYPE_SIMILARITY = 0.66  # two letters of three, as in "pyl"
MIN_SIMILARITY = 0.7


def find_similar(word: str, known: Iterable[str], min_similarity: float = MIN_SIMILARITY) -> list[str]:
    """Return the word of `known` that resembles `word` most, or nothing."""
    from difflib import get_close_matches

    return get_close_matches(word, list(known), 1, min_similarity)


def did_you_mean(word: str, known: Iterable[str], min_similarity: float = MIN_SIMILARITY) -> str:
    """Return the end of an error about an unknown word, such as "; did you mean 'viridis'?"; may be empty."""
    similar = find_similar(word, known, min_similarity)
    return f"; did you mean {similar[0]!r}?" if similar else ""
