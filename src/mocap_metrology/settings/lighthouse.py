"""Settings of calibrations, and of the simulated studies of them."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field

from mocap_metrology.common.sections import Section, Unique, Words

PoseEstimator = Literal["batch", "paper", "paper-tight", "paper-lm", "pnp", "geometric"]
Optics = Literal["ideal", "factory", "estimated"]
SimplexOptics = Literal["ideal", "factory"]
WorldFrame = Literal["gravity", "master", "board-start", "points"]

Millimetres = Annotated[float, Field(ge=-200, le=200)]


class Lighthouse(Section):
    """Calibration of base stations."""

    sample_rate_hz: float = Field(2000000.0, ge=100000, le=100000000)
    """Words per second of a GPIO dump."""
    active_level: Annotated[int, Words("0 or 1", "`0`, `1`")] = Field(1, ge=0, le=1)
    """Value of a bit while its diode is lit."""
    gate_mrad: float = Field(1.5, gt=0)
    """A hit is an outlier if it deviates from the others of its sweep by more than this and by more
    than `gate_mad`."""
    gate_mad: float = Field(8.0, ge=3)
    """The second limit, in MAD of the sweep."""
    still_half_window: int = Field(15, ge=2)
    """Hampel filter of each diode while the board is at rest: sweeps on each side."""
    still_n_sigma: float = Field(4.0, ge=3)
    """Threshold of this filter, in 1.4826 MAD."""
    estimators: Annotated[
        tuple[PoseEstimator, ...],
        AfterValidator(Unique("paper-lm")),
    ] = ("batch", "paper", "paper-tight", "paper-lm")
    """Estimators of the pose, with `paper-lm` among them; each is described below. The pose of
    `batch` is chosen where it is among them and converges."""
    optics: Annotated[tuple[Optics, ...], AfterValidator(Unique(least=1))] = (
        "ideal",
        "factory",
        "estimated",
    )
    """`ideal` is J's; `factory` uses the values of the maker that the flashes carry; `estimated`
    estimates them with the pose, by `batch`, where they are not known."""
    simplex_optics: Annotated[tuple[SimplexOptics, ...], AfterValidator(Unique())] = ("ideal",)
    """Optics of `paper` and `paper-tight`, each of which takes a second."""
    reconstruction: Literal["full-interpolation", "dominant-axis", "pairs"] = "full-interpolation"
    """Method that brings both angles to one moment (J section IV)."""
    lm_interpolation: Literal["linear", "cubic"] = "cubic"
    """Interpolation of `paper-lm`; the others are linear, as in J."""
    lm_weights: Literal["path", "none"] = "path"
    """Whether the last stage of `paper-lm` includes the uncertainty of the path of the board; J
    treats it as exact."""
    start_distance_m: float = Field(3.0, ge=0.1, le=20)
    """Distance of the board in the first guess of `paper`, in m; J does not state it."""
    variant: Literal["auto", "crazyflie", "libsurvive", "astrobee"] = "auto"
    """Meaning of the factory values where open-source drivers differ (sign of curve, argument of
    the gibbous term). `auto` fits each variant and selects the one with the smallest residual of
    both stations; variants that the recording does not exclude increase the covariance. `pose.json`
    lists all under `variants`."""
    pnp_method: Literal["auto", "epnp", "ippe", "sqpnp"] = "auto"
    """Method of `pnp`; `auto` is `ippe` on flat boards."""
    lasers_mm: Annotated[
        tuple[Millimetres, ...] | None,
        Field(min_length=12, max_length=12),
        Words(
            "nothing, or twelve numbers of mm, x, y and z of the lasers of axis 0 and 1 of the "
            "master, then of the slave",
            "twelve numbers",
        ),
    ] = None
    """Positions of the lasers in their housings: x, y, z of axis 0 and axis 1 of the master, then
    of the slave. Poses are then of the housings, otherwise of the optics."""
    board_position_sd_mm: float = Field(0.2, ge=0, le=10)
    """Of `batch`, as are the next four: standard deviation of the coordinates of a diode in the
    board file. 0: exact. Less is used where the recording shows that they are better."""
    board_scale_sd: float = Field(0.001, ge=0, le=0.1)
    """Relative standard deviation of the board's scale, which no angle shows: the distance of the
    stations has the same. Of boards below 0.3 m it is at least 0.3 mm over the largest distance of
    two diodes, unless it is 0, or the cover of a deep object is estimated before V2 stations.
    Column `known_length` reduces it."""
    laser_depth_sd_mm: float = Field(10.0, ge=0, le=100)
    """Standard deviation of the distance in depth between both lasers of a station, with `factory`
    optics and where `lasers_mm` does not name it."""
    phase_sd_mrad: float = Field(1.0, ge=0, le=100)
    """Standard deviation of the phases of the maker, with `factory` optics. An error of a phase is
    not visible in the residual."""
    time_zero_sd_us: float = Field(0.15, ge=0, le=10)
    """Standard deviation of the time zero of a station and axis: diodes see a flash rise late, each
    by its own delay."""
    world: WorldFrame = "gravity"
    """Frame of the room in `crazyflie.yaml`, `libsurvive.json`, `ros2_static_transforms.launch.xml`
    and under `world` of `pose.json`. `gravity`: z up by the accelerometers of the stations, origin
    at the master, x horizontal as the master looks; `master`: the master's own frame;
    `board-start`: the board's frame, where it was at the start of the recording; `points`: that of
    column `world_points`, which a row with such a file always has. Where the data for a frame is
    missing, it is `gravity`, by the stations or by the geometry in a Crazyflie's file, else
    `board-start`, else `master`; files and terminal state it and why."""
    inertial: bool = False
    """Whether `batch` uses the gyroscope and the accelerometer of a `.rec` besides the light.
    Biases, scale, delay, orientation and place of both are estimated. It pays for small boards."""
    gravity: bool = False
    """Whether `batch` uses the way up that each station transmits, with a standard deviation of 1.5
    deg. It pays where the pose is known no better; the verdict compares both in any case."""
    joint: Literal["none", "setup"] = "none"
    """`setup`: besides each recording alone, all recordings of a setup in one estimate by `batch`,
    `setups/<group>/<setup>/pose.json`. Objects may differ, and a recording may see a part of the
    stations. It is the way to calibrate stations whose factory values are not known: record at five
    places or more."""

    def of_one(self) -> dict[str, Any]:
        """What determines the result of a single recording, by name."""
        return self.model_dump(exclude={"joint"})


Speed = Annotated[float, Field(ge=0.02, le=5)]
Distance = Annotated[float, Field(ge=1.25, le=10)]
Baseline = Annotated[float, Field(ge=0.2, le=5)]
Diodes = Annotated[int, Field(ge=3, le=32)]
Offset = Annotated[float, Field(ge=0, le=100)]
LaserDistance = Annotated[float, Field(ge=0.75, le=10)]
TWO = AfterValidator(Unique(least=2))


def _numbers(low: str, high: str, unit: str = "") -> Words:
    """Words on a list of numbers."""
    words = f"a list of numbers{unit} >= {low} and <= {high}, at least two, each at most once"
    return Words(words, f"each >= {low}, <= {high}")


class JansenStudies(Section):
    """Simulated studies of J's claims, by `snakemake jansen_studies`."""

    recordings: int = Field(20, ge=2, le=10000)
    """Simulated recordings at each point of a study. Fewer than six give no interval of a
    median."""
    duration_s: float = Field(4.0, ge=1, le=60)
    """Length of these recordings, in s; J's are of 8 s."""
    speeds_m_s: Annotated[tuple[Speed, ...], TWO, _numbers("0.02", "5", " of m/s")] = (
        *(0.1, 0.2, 0.5, 1.0, 2.0),
    )
    """Speeds of the board at which the ways of reconstruction are compared."""
    patterns: Annotated[tuple[Literal["line", "arc", "circle", "hand"], ...], TWO] = (
        *("line", "arc", "circle", "hand"),
    )
    """Motion patterns that are compared."""
    distances_m: Annotated[tuple[Distance, ...], TWO, _numbers("1.25", "10", " of m")] = (
        *(2.0, 3.0, 4.0, 5.0, 6.0),
    )
    """Distances of the board from both stations, which are 2 m apart."""
    baselines_m: Annotated[tuple[Baseline, ...], TWO, _numbers("0.2", "5", " of m")] = (
        *(1.0, 2.0, 3.0, 4.0),
    )
    """Distances between the stations, 3 m from the board."""
    diodes: Annotated[tuple[Diodes, ...], TWO, _numbers("3", "32")] = (3, 4, 8, 16, 32)
    """Numbers of diodes on a board of the same size."""
    laser_offsets_mm: Annotated[tuple[Offset, ...], TWO, _numbers("0", "100", " of mm")] = (
        *(0.0, 5.0, 10.0, 25.0),
    )
    """Distances of the lasers from the middle of their station, in random directions."""
    laser_distances_m: Annotated[
        tuple[LaserDistance, ...], AfterValidator(Unique(least=1)), _numbers("0.75", "10", " of m")
    ] = (1.0, 2.5, 6.0)
    """Distances of the board at which these offsets are compared; the stations are 1 m apart."""
