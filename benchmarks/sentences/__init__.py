"""Monte Carlo behind docs/accuracy.md; one module a subject, each with `rows(n)`."""

Row = tuple[str, str, int, str, str]  # case, statistic, runs, reach, measured


def percent(hold: object) -> str:
    """`93 %` of flags, or nothing where there are none."""
    flags = list(hold)
    return f"{100 * (sum(flags) / len(flags)):.0f} %" if flags else ""
