"""Uncertainty budgets in the manner of the GUM (JCGM 100:2008).

u_c^2 = sum u_i^2 of uncorrelated components (clause 5.1, sensitivities taken into u_i), effective
degrees of freedom by Welch & Satterthwaite, nu_eff = u_c^4 / sum (u_i^4 / nu_i) (G.2b), coverage
factor k = t_p(nu_eff) (G.3), not rounded down, and U = k u_c.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

COVERAGE = 0.95


@dataclass(frozen=True)
class Component:
    """One component of an uncertainty budget. name: key of its words; kind: type of evaluation, `A`
    by statistics, `B` by other means; u: standard uncertainty; dof: its degrees of freedom."""

    name: str
    kind: str
    u: float
    dof: float = math.inf


@dataclass(frozen=True)
class Budget:
    """Uncorrelated components of one quantity, all in its unit."""

    components: tuple[Component, ...]

    @property
    def u(self) -> float:
        """Combined standard uncertainty."""
        return math.hypot(*(one.u for one in self.components))

    @property
    def dof(self) -> float:
        """Effective degrees of freedom, infinite where all that count are."""
        return effective_dof([one.u for one in self.components], [c.dof for c in self.components])

    @property
    def k(self) -> float:
        """Coverage factor of 95 %."""
        return coverage_factor(self.dof)

    @property
    def expanded(self) -> float:
        """U = k u_c."""
        return self.k * self.u

    def share(self, component: Component) -> float:
        """Share of the component in u_c^2."""
        return component.u**2 / self.u**2 if self.u > 0 else 0.0


def effective_dof(u: Sequence[float], dof: Sequence[float]) -> float:
    """(sum u_i^2)^2 / sum (u_i^4 / nu_i)."""
    lost = sum(one**4 / nu for one, nu in zip(u, dof, strict=True))
    return sum(one**2 for one in u) ** 2 / lost if lost > 0 else math.inf


def coverage_factor(dof: float, coverage: float = COVERAGE) -> float:
    """Quantile (1 + p) / 2 of Student's t, of the normal distribution for infinite dof."""
    from scipy.special import ndtri, stdtrit

    p = (1 + coverage) / 2
    return float(stdtrit(dof, p) if math.isfinite(dof) else ndtri(p))
