"""What can go wrong, one class per cause.  Nothing here ever stands for "no contact"."""


class FirstContactError(Exception):
    """Base of every error this library raises on purpose; its text is one line."""

    def __init__(self, text: str = "") -> None:
        super().__init__(" ".join(str(text).split("\n")))


class InputError(FirstContactError, ValueError):
    """The input is malformed; the text names the body, element, key or line and says what to do."""


class UnsupportedPair(FirstContactError):
    """The question is well formed, but no exact method for this pair of bodies and motions exists here."""
