"""The exceptions that a user is meant to read."""


class Refusal(ValueError):
    """Input that cannot be used. The message is one line: what, where, what was expected."""

    def __init__(self, message: str):
        super().__init__(" ".join(str(message).split()))


class Truncated(Refusal):
    """A file that ends early, of which what is there could be used."""


class UnknownUnit(Refusal):
    """A file whose unit of length is not told, or not believed, until the user states it."""


class Unseen(Refusal):
    """A marker that is seen in no frame of an otherwise good file."""
