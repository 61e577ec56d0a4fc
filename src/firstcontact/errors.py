"""What can go wrong, one class per cause.  Nothing here ever stands for "no contact"."""

import re
from fractions import Fraction

# Letters of one word of a message, and of a message, that are shown; what is between the beginning and the end is not.
LONGEST_WORD, LONGEST_LINE = 240, 2000


class FirstContactError(Exception):
    """Base of every error this library raises on purpose; its text is one line that a reader can take in."""

    def __init__(self, text: str = "") -> None:
        super().__init__(one_line(text))


class InputError(FirstContactError, ValueError):
    """The input is malformed; the text names the body, element, key or line and says what to do."""


class UnsupportedPair(FirstContactError):
    """The question is well formed, but no exact method for this pair of bodies and motions exists here."""


def one_line(text: str) -> str:
    """The text without line breaks, and without the middle of words and of itself where these are very long."""
    line = " ".join(str(text).splitlines())
    line = re.sub(rf"\S{{{LONGEST_WORD + 1},}}", lambda word: _shortened(word[0], LONGEST_WORD), line)
    return _shortened(line, LONGEST_LINE)


def shown(value: object) -> str:
    """`repr`, also of whole numbers with more digits than Python prints."""
    try:
        return str(value) if isinstance(value, Fraction) else repr(value)
    except ValueError:
        return f"a {type(value).__name__} of thousands of digits"


def _shortened(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[: most // 2]}...{text[-most // 3 :]}"
