"""The one exception that a user is meant to read."""


class Refusal(ValueError):
    """Input that cannot be used. The message is one line: what, where, what was expected."""

    def __init__(self, message: str):
        super().__init__(" ".join(str(message).split()))
