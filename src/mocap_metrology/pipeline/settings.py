"""Settings of what is computed of one file, and their defaults: sections and keys of config.yaml.

Their meanings and ranges are in the models that check a configuration
(`mocap_workflow.settings`), which take their defaults from here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Action = Literal["replace", "mask", "off"]
AllanEstimator = Literal["oadev", "mdev", "hdev"]
NoiseEstimator = Literal[
    "likelihood",
    "annealing-ant-colony",
    "annealing-ant-colony-plain",
    "levenberg-marquardt",
    "slopes",
]
Form = Literal["sampled", "continuous"]
Word = Literal["good", "usable", "bad"]
PoseEstimator = Literal["batch", "paper", "paper-tight", "paper-lm", "pnp", "geometric"]
Optics = Literal["ideal", "factory", "estimated"]
SimplexOptics = Literal["ideal", "factory"]
WorldFrame = Literal["gravity", "master", "board-start", "points"]


@dataclass(frozen=True)
class Hampel:
    half_window_s: float = 1.0
    n_sigma: float = 3.0
    action: Action = "replace"


@dataclass(frozen=True)
class Allan:
    n_taus: int = 100
    min_m: int = 1
    max_fraction: float = 0.3333333
    estimators: tuple[AllanEstimator, ...] = ("oadev",)
    confidence: float = 0.683
    min_coverage: float = 0.5


@dataclass(frozen=True)
class Spectrum:
    segment_s: float = 600.0
    overlap: float = 0.5


@dataclass(frozen=True)
class Still:
    range_mm: float = 2.0


@dataclass(frozen=True)
class Verdict:
    horizon_s: float = 3600.0
    window_s: float = 1.0
    good_mm: float = 0.1
    usable_mm: float = 0.25
    good_drift_mm: float = 0.35
    usable_drift_mm: float = 0.85
    good_missing: float = 0.01
    usable_missing: float = 0.1
    good_outliers: float = 0.01
    usable_outliers: float = 0.05
    good_duration_s: float = 60.0
    good_markers: int = 2
    misfit: Word = "usable"


@dataclass(frozen=True)
class Gaussian:
    n_bins: int = 30


@dataclass(frozen=True)
class Diagnosis:
    false_alarm: float = 0.01
    side_s: float = 300.0
    spike_sigma: float = 6.0
    cutoffs_hz: tuple[float, ...] = (6.0, 10.0)
    notch_width_hz: float = 1.0
    max_lines: int = 10


@dataclass(frozen=True)
class Noise:
    estimators: tuple[NoiseEstimator, ...] = (
        "likelihood",
        "annealing-ant-colony",
        "levenberg-marquardt",
        "slopes",
    )
    mask_sigma: float = 6.0
    criterion: Literal["bic", "aicc"] = "bic"
    max_gauss_markov: int = 4
    sinusoid: bool = True
    form: Form = "continuous"
    gauss_markov: int = 3


@dataclass(frozen=True)
class Annealing:
    starts: int = 10
    iterations: int = 3
    temperature: float = 5230.0
    descent: int = 20
    archive: int = 50
    ants: int = 10
    q: float = 0.1
    xi: float = 0.85
    colony_iterations: int = 100
    jitter: float = 0.1
    plain_iterations: int = 1000
    plain_colony_iterations: int = 2000
    negligible: float = 1e-05
    largest: float = 1.5
    shortest_frames: float = 2.0
    longest_share: float = 0.1
    lowest_hz: float = 0.01
    longest_tau_share: float = 0.03


@dataclass(frozen=True)
class Lighthouse:
    sample_rate_hz: float = 2000000.0
    active_level: int = 1
    gate_mrad: float = 1.5
    gate_mad: float = 8.0
    still_half_window: int = 15
    still_n_sigma: float = 4.0
    estimators: tuple[PoseEstimator, ...] = ("batch", "paper", "paper-tight", "paper-lm")
    optics: tuple[Optics, ...] = ("ideal", "factory", "estimated")
    simplex_optics: tuple[SimplexOptics, ...] = ("ideal",)
    reconstruction: Literal["full-interpolation", "dominant-axis", "pairs"] = "full-interpolation"
    lm_interpolation: Literal["linear", "cubic"] = "cubic"
    lm_weights: Literal["path", "none"] = "path"
    start_distance_m: float = 3.0
    variant: Literal["auto", "crazyflie", "libsurvive", "astrobee"] = "auto"
    pnp_method: Literal["auto", "epnp", "ippe", "sqpnp"] = "auto"
    lasers_mm: tuple[float, ...] | None = None
    board_position_sd_mm: float = 0.2
    board_scale_sd: float = 1e-3
    laser_depth_sd_mm: float = 10.0
    phase_sd_mrad: float = 1.0
    time_zero_sd_us: float = 0.15
    world: WorldFrame = "gravity"
    inertial: bool = False
    gravity: bool = False


@dataclass(frozen=True)
class Settings:
    """Of one recording or one calibration."""

    seed: int = 2019
    second_opinion: bool = True
    hampel: Hampel = Hampel()
    allan: Allan = Allan()
    psd: Spectrum = Spectrum()
    still: Still = Still()
    verdict: Verdict = Verdict()
    gaussian: Gaussian = Gaussian()
    diagnosis: Diagnosis = Diagnosis()
    noise: Noise = Noise()
    annealing: Annealing = Annealing()
    lighthouse: Lighthouse = Lighthouse()


DEFAULTS = Settings()
