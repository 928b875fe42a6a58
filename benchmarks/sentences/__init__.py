"""Monte Carlo behind docs/accuracy.md; one module a subject, each with `rows(n)`."""
