"""What can go wrong, one class per cause.  Nothing here ever stands for "no contact"."""


class FirstContactError(Exception):
    """Base of every error this library raises on purpose."""


class InputError(FirstContactError, ValueError):
    """The input is malformed; the text names the body, element, key or line and says what to do."""


class UnsupportedPair(FirstContactError):
    """The question is well formed, but no exact method for this pair of bodies and motions exists here."""
