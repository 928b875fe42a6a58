"""Noise model of one coordinate: power laws, Gauss-Markov components, a sinusoid.

One-sided spectra S(f) in mm^2/Hz, f in (0, Nyquist]; Allan variances in mm^2 at tau = m tau0;
tau0 = 1 / frame_rate_hz the frame period in s. Two forms of each:

* `sampled`: the camera samples points, so S is folded to 0..Nyquist and tau-averages are means of m
  points: AVAR = 2 Int_0^fN S(f) sin^4(pi f m tau0) / (m sin(pi f tau0))^2 df (the discrete form of
  the Allan transfer function; Walter, IEEE Trans. Instrum. Meas. 43, 1994). Exact at every m.
* `continuous`: the textbook forms, as Skurowski & Pawlyta 2019 (Table 1 and the two formulas after
  it) print them, with lost signs and brackets restored: averages over continuous time. Frames that
  are averages over the frame period have exactly these, and `psd` is then theirs (`sampling`).

Sampled flicker, blue and violet noise are h f^alpha band-limited at Nyquist; so are blue and violet
in continuous form. A coefficient is the one of the spectrum, so both forms share it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import ClassVar, Literal

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.model.sampling import (
    band_limited,
    correlated_bracket,
    correlated_means,
    power_law_means,
    sinh_minus,
)

Form = Literal["sampled", "continuous"]
FORMS: tuple[Form, ...] = ("sampled", "continuous")
ALPHAS = (-2, -1, 0, 1, 2)
NAMES = re.compile(r"h_(-2|-1|0|1|2)|([qT]_c)([1-9]\d*)|A_s|f_0|width_f")


def four_sin2(f: np.ndarray, frame_rate_hz: float) -> np.ndarray:
    """|1 - exp(-2 pi i f tau0)|^2 = 4 sin^2(pi f tau0): the gain of first differences."""
    tau0 = 1 / frame_rate_hz
    return 4.0 * np.sin(np.pi * tau0 * np.asarray(f, float)) ** 2


@dataclass(frozen=True)
class PowerLaw:
    """S(f) = h f^alpha, alpha in -2..2 (S Table 1); h in mm^2 Hz^(-1-alpha)."""

    alpha: int
    h: float

    def __post_init__(self) -> None:
        _require(self.alpha in ALPHAS, f"power law: alpha {self.alpha}, expected one of {ALPHAS}")
        _require(0 <= self.h < math.inf, f"h_{self.alpha} = {self.h}, expected a number >= 0")

    def psd(
        self,
        f: np.ndarray,
        frame_rate_hz: float,
        gain: np.ndarray | None = None,
        form: Form = "sampled",
    ) -> np.ndarray:
        """Spectrum of point samples. Random walk is the sum of all aliases of h/f^2 in closed form,
        h (pi tau0)^2 / sin^2(pi f tau0): steps of variance 2 pi^2 tau0 h. The others are h f^alpha
        up to Nyquist. `gain`: `four_sin2(f, frame_rate_hz)` where the caller has it. `form`
        continuous: of frames that are averages over the frame period (`sampling`)."""
        gain = four_sin2(f, frame_rate_hz) if gain is None else gain
        if form == "continuous":
            return self.h * power_law_means(self.alpha, f, frame_rate_hz, gain)
        if self.alpha == -2:
            return self.h * (2 * np.pi * (1 / frame_rate_hz)) ** 2 / gain
        return self.h * np.asarray(f, float) ** float(self.alpha)

    def avar(self, m: np.ndarray, frame_rate_hz: float, form: Form = "sampled") -> np.ndarray:
        """Closed forms; sampled flicker, blue and violet by `sampling.band_limited`."""
        tau0 = 1 / frame_rate_hz
        m = np.asarray(m, float)
        tau = m * tau0
        if self.alpha == 0:
            return self.h / (2 * tau)
        if form == "sampled" and self.alpha == -2:
            return self.h * np.pi**2 * tau0 * (2 * m**2 + 1) / (3 * m)
        if form == "sampled":
            unit = 2 * tau0 ** -(self.alpha + 1.0) / m**2
            return self.h * unit * band_limited(self.alpha, m)
        if self.alpha == -2:
            return self.h * 2 * np.pi**2 / 3 * tau
        if self.alpha == -1:
            return self.h * 2 * np.log(2) * np.ones_like(tau)
        nyquist = 0.5 / tau0
        if self.alpha == 1:
            # 3 gamma - ln 2 = 1.0385, printed 1.038
            bracket = 3 * (np.euler_gamma + np.log(2 * np.pi * nyquist * tau)) - np.log(2)
            return self.h * bracket / (2 * np.pi * tau) ** 2
        return self.h * 3 * nyquist / (2 * np.pi * tau) ** 2


@lru_cache(maxsize=64)
def unit_avar(alpha: int, form: Form, frame_rate_hz: float, m: bytes) -> np.ndarray:
    """Allan variance of h = 1 at m, bytes of floats: integrals, and the same for every series."""
    return PowerLaw(alpha, 1.0).avar(np.frombuffer(m), frame_rate_hz, form)


@dataclass(frozen=True)
class GaussMarkov:
    """Exponentially correlated noise: autocovariance (q_c^2 T_c/2) exp(-|t|/T_c), mm^2;
    q_c in mm/sqrt(s), T_c in s."""

    q_c: float
    T_c: float

    def __post_init__(self) -> None:
        _require(0 <= self.q_c < math.inf, f"q_c = {self.q_c}, expected a number >= 0")
        _require(0 < self.T_c < math.inf, f"T_c = {self.T_c}, expected a number > 0 (in s)")

    @property
    def variance(self) -> float:
        """q_c^2 T_c / 2 in mm^2."""
        return self.q_c**2 * self.T_c / 2

    def psd(
        self,
        f: np.ndarray,
        frame_rate_hz: float,
        gain: np.ndarray | None = None,
        form: Form = "sampled",
    ) -> np.ndarray:
        """Spectrum of point samples, that of an AR(1) series with phi = exp(-tau0/T_c):
        2 tau0 var (1 - phi^2) / (1 - 2 phi cos(2 pi f tau0) + phi^2). `form` continuous: of frames
        that are averages over the frame period, ARMA(1, 1) (`sampling`)."""
        tau0 = 1 / frame_rate_hz
        gain = four_sin2(f, frame_rate_hz) if gain is None else gain
        a = tau0 / self.T_c
        if form == "continuous":
            return 2 * tau0 * self.variance * correlated_means(a, gain)
        # 1 - 2 phi cos + phi^2 = (1 - phi)^2 + 4 phi sin^2, which keeps its digits as phi -> 1
        denominator = np.expm1(-a) ** 2 + math.exp(-a) * gain
        return 2 * tau0 * self.variance * -np.expm1(-2 * a) / denominator

    def avar(self, m: np.ndarray, frame_rate_hz: float, form: Form = "sampled") -> np.ndarray:
        """Closed forms; with x = m tau0/T_c, a = tau0/T_c, G(x) = 2x - 3 + 4 e^-x - e^-2x:
        sampled    var [2m (sinh a - a) + G(x)] / (2 m sinh(a/2))^2,
        continuous var G(x) / x^2. Both are sums of positive terms, so no digits cancel."""
        tau0 = 1 / frame_rate_hz
        m = np.asarray(m, float)
        a = tau0 / self.T_c
        x = m * a
        if form == "continuous":
            return self.variance * correlated_bracket(x) / x**2
        # Far below the frame period the series is white: sinh a overflows, the ratio does not.
        if a > 300:
            return self.variance / m
        points = 2 * m * sinh_minus(a)
        return self.variance * (points + correlated_bracket(x)) / (2 * m * math.sinh(a / 2)) ** 2


@dataclass(frozen=True)
class Sinusoid:
    """A_s sin(2 pi f_0 t + phase): a line, so it has an Allan variance but no density. Averaged
    over the frame period it is A_s sinc(f_0 tau0) high (`recorded`).

    width_f: standard deviation of its frequency over time, Hz; 0 where the recording resolves none.
    The Allan variance is that of a line without width, which it differs from by (width_f / f_0)^2.
    """

    A_s: float
    f_0: float
    width_f: float = 0.0

    def __post_init__(self) -> None:
        _require(0 <= self.A_s < math.inf, f"A_s = {self.A_s}, expected a number >= 0")
        _require(0 < self.f_0 < math.inf, f"f_0 = {self.f_0}, expected a number > 0 (in Hz)")
        _require(0 <= self.width_f < math.inf, f"width_f = {self.width_f}, expected a number >= 0")

    def recorded(self, frame_rate_hz: float, form: Form = "sampled") -> float:
        """Amplitude in frames that are points, or averages over the frame period; mm."""
        tau0 = 1 / frame_rate_hz
        return self.A_s * abs(float(np.sinc(self.f_0 * tau0))) if form == "continuous" else self.A_s

    def avar(self, m: np.ndarray, frame_rate_hz: float, form: Form = "sampled") -> np.ndarray:
        """Mean over the phase; sampled A^2 sin^4(pi f m tau0) / (m sin(pi f tau0))^2, continuous
        A^2 (sin^2(x)/x)^2 with x = pi f tau (S prints it without the outer square)."""
        tau0 = 1 / frame_rate_hz
        m = np.asarray(m, float)
        x = np.pi * self.f_0 * tau0
        if form == "continuous":
            return self.A_s**2 * (np.sin(m * x) ** 2 / (m * x)) ** 2
        if abs(math.sin(x)) < 1e-12 * max(1.0, x):  # aliased to a constant
            return np.zeros_like(m)
        return self.A_s**2 * np.sin(m * x) ** 4 / (m * math.sin(x)) ** 2


Component = PowerLaw | GaussMarkov | Sinusoid


@dataclass(frozen=True)
class NoiseModel:
    """A sum of independent components: at most one power law of each alpha and one sinusoid; in
    frames of that form, unless another is requested."""

    components: tuple[Component, ...] = ()
    form: Form = "sampled"
    UNITS: ClassVar[Mapping[str, str]] = {
        "h_-2": "mm^2 Hz",
        "h_-1": "mm^2",
        "h_0": "mm^2/Hz",
        "h_1": "mm^2/Hz^2",
        "h_2": "mm^2/Hz^3",
        "q_c": "mm/s^0.5",
        "T_c": "s",
        "A_s": "mm",
        "f_0": "Hz",
        "width_f": "Hz",
    }

    def __post_init__(self) -> None:
        object.__setattr__(self, "components", tuple(self.components))
        check_form(self.form)
        alphas = [c.alpha for c in self.components if isinstance(c, PowerLaw)]
        _require(len(alphas) == len(set(alphas)), "noise model: one power law an alpha at most")
        _require(len(self.lines) <= 1, "noise model: one sinusoid at most")

    @property
    def lines(self) -> tuple[Sinusoid, ...]:
        """The components that have no density."""
        return tuple(c for c in self.components if isinstance(c, Sinusoid))

    @property
    def broadband(self) -> tuple[PowerLaw | GaussMarkov, ...]:
        """The components that have a density."""
        return tuple(c for c in self.components if not isinstance(c, Sinusoid))

    def psd(self, f: np.ndarray, frame_rate_hz: float, form: Form | None = None) -> np.ndarray:
        """One-sided spectrum of frames that are points (`sampled`) or averages over the frame
        period (`continuous`), mm^2/Hz, at 0 < f <= 1/(2 tau0); without the sinusoid."""
        form = check_form(form or self.form)
        f = np.asarray(f, float)
        gain = four_sin2(f, frame_rate_hz)
        return sum((c.psd(f, frame_rate_hz, gain, form) for c in self.broadband), np.zeros_like(f))

    def avar(self, m: np.ndarray, frame_rate_hz: float, form: Form | None = None) -> np.ndarray:
        """Allan variance, mm^2, at tau = m tau0 (m whole numbers >= 1, any shape)."""
        form = check_form(form or self.form)
        m = np.asarray(m, float)
        return sum((c.avar(m, frame_rate_hz, form) for c in self.components), np.zeros_like(m))

    def scaled(self, factor: float) -> NoiseModel:
        """The model of `factor` times the series: h by factor^2, q_c and A_s by factor."""
        return replace(self, components=tuple(_scaled(c, factor) for c in self.components))

    def ordered(self) -> NoiseModel:
        """The same model: power laws by alpha, Gauss-Markov by rising T_c, sinusoid."""
        return replace(self, components=tuple(sorted(self.components, key=_rank)))

    def coefficients(self) -> dict[str, float]:
        """`h_-2` ... `h_2`, `q_c1`, `T_c1`, ... (numbered in their order), `A_s`, `f_0`, and
        `width_f` where there is one."""
        values: dict[str, float] = {}
        laws = sorted((c for c in self.broadband if isinstance(c, PowerLaw)), key=_rank)
        terms = (c for c in self.broadband if isinstance(c, GaussMarkov))
        values |= {f"h_{c.alpha}": c.h for c in laws}
        for k, c in enumerate(terms, start=1):
            values |= {f"q_c{k}": c.q_c, f"T_c{k}": c.T_c}
        for line in self.lines:
            values |= {"A_s": line.A_s, "f_0": line.f_0}
            values |= {"width_f": line.width_f} if line.width_f else {}
        return values

    @classmethod
    def from_coefficients(
        cls, coefficients: Mapping[str, float], form: Form = "sampled"
    ) -> NoiseModel:
        """The model of the named coefficients; what is not named is not there."""
        for name, value in coefficients.items():
            _require(
                bool(NAMES.fullmatch(str(name))),
                f"noise coefficient {name!r}, expected h_-2 ... h_2, q_c1, T_c1, ..., A_s, f_0 or "
                "width_f",
            )
            number = isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
            _require(number, f"noise coefficient {name}: {value!r}, expected a number")
        values = {name: float(value) for name, value in coefficients.items()}
        parts: list[Component] = [
            PowerLaw(a, values[f"h_{a}"]) for a in ALPHAS if f"h_{a}" in values
        ]
        numbers = sorted({int(name[3:]) for name in values if name[:3] in ("q_c", "T_c")})
        pairs = [(f"q_c{n}", f"T_c{n}") for n in numbers]
        for pair in [*pairs, ("A_s", "f_0")] if {"A_s", "f_0", "width_f"} & {*values} else pairs:
            missing = [name for name in pair if name not in values]
            _require(not missing, f"noise coefficients {', '.join(pair)}: {missing} is missing")
            first, second = (values[name] for name in pair)
            line = pair[0] == "A_s"
            width = values.get("width_f", 0.0)
            parts.append(Sinusoid(first, second, width) if line else GaussMarkov(first, second))
        return cls(tuple(parts), form)


def check_form(form: object) -> Form:
    """The form, if it is one."""
    if form not in FORMS:
        raise Refusal(f"form {form!r}, expected {' or '.join(FORMS)}")
    return "sampled" if form == "sampled" else "continuous"


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise Refusal(message)


def _scaled(component: Component, factor: float) -> Component:
    if isinstance(component, PowerLaw):
        return PowerLaw(component.alpha, component.h * factor**2)
    if isinstance(component, GaussMarkov):
        return GaussMarkov(component.q_c * abs(factor), component.T_c)
    return replace(component, A_s=component.A_s * abs(factor))


def _rank(component: Component) -> tuple[int, float]:
    if isinstance(component, PowerLaw):
        return 0, component.alpha
    return (1, component.T_c) if isinstance(component, GaussMarkov) else (2, component.f_0)
