# A recording is three jobs: clean, noise, verdict. Parquet between them is the cache: a changed
# setting of the noise reads no recording, a changed caption fits no noise. Of a bar that is moved
# there are two: take_bar, bar.

MEASURED_FILES = files(selection.paths)
ENTRY = ("markers", "frame_rate_hz", "accept_truncated", "unit", "column_names")
ORIGIN = ("recording", "source", "twin", "pairs")  # what tables are marked with
OF_BAR = ("bar", "length_mm", "length_u_mm", "bar_pose")
ROW = columns("recording", "group", "twin", "camera_type", "n_cameras")
CLEANED = {
    "trajectories": of_recording("trajectories.parquet"),
    "clean": of_recording("clean.parquet"),
    "outliers": of_recording("outliers.csv"),
}
BAR_TAKE = {"take": of_recording("bar.parquet")}
READ_AS_BAR = {  # params of both rules
    "entry": columns(*ENTRY),
    "origin": columns("recording", "source", "twin", "date"),
    "bar": columns(*OF_BAR),
    "settings": settings("seed", "second_opinion", bar=["rigid_mm", "least_path_mm"]),
}


def promised(outputs, query, choose=selection.names, target="recordings"):
    """Add outputs of recordings to a target: of those that `choose` names of a query."""
    promise(**{target: collect(outputs, recording=accepted(choose, query))})


# A refusal is a result: this rule succeeds, check.json states the reason, and tables are empty.
checkpoint clean:
    input:
        MEASURED_FILES,
    output:
        **CLEANED,
        check=of_recording("check.json"),
    log:
        "<logs>/clean/{recording}.log",
    benchmark:
        "<benchmarks>/clean/{recording}.tsv"
    wildcard_constraints:
        recording=RECORDINGS.pattern(source="measured", about="noise"),
    priority: 10
    resources:
        mem_mb=memory(4000, arrays=9),
        runtime=minutes(30, seconds=2.5),
    params:
        code=source("clean.py"),
        contents=contents(selection.paths),
        # Paths, too: of the inputs Snakemake compares the set alone, and here their order counts
        paths=cell("paths"),
        entry=columns(*ENTRY, "sha256"),
        origin=columns(*ORIGIN),
        settings=settings("hampel", "still", "second_opinion", verdict=["horizon_s"]),
    message:
        "{wildcards.recording}: reading, checking and cleaning"
    script:
        "../scripts/clean.py"


# A twin needs no check, so it is known to be accepted before anything runs.
job(
    "clean_twin",
    of="recording",
    script="clean",
    only={"recording": RECORDINGS.pattern(source="twin", about="noise")},
    output={"truth": of_recording("truth.json"), **CLEANED},
    mem_mb=memory(1000, arrays=9),
    runtime=minutes(30, seconds=2.5),
    params={
        "entry": columns(*ENTRY),
        "origin": of_row(
            lambda row: {name: getattr(row, name) for name in ORIGIN}
            | {"form": selection.form(row, TWINS)}
        ),
        "twin": twin_of(TWINS),
        "settings": settings("hampel", "seed"),
    },
    message="simulating and cleaning",
)
promised([of_recording("truth.json")], SIMULATED)
promised(CLEANED.values(), ABOUT_NOISE)


# As `clean` of a bar that is moved. Its noise is no noise: nothing is cleaned or fitted.
checkpoint take_bar:
    input:
        MEASURED_FILES,
    output:
        **BAR_TAKE,
        check=of_recording("check.json"),
    log:
        "<logs>/take_bar/{recording}.log",
    benchmark:
        "<benchmarks>/take_bar/{recording}.tsv"
    wildcard_constraints:
        recording=RECORDINGS.pattern(source="measured", about="bar"),
    priority: 10
    resources:
        mem_mb=memory(2000, arrays=12),
        runtime=minutes(30, seconds=2.5),
    params:
        **READ_AS_BAR,
        code=source("take_bar.py"),
        contents=contents(selection.paths),
        paths=cell("paths"),
        sha256=cell("sha256"),
    message:
        "{wildcards.recording}: reading the bar"
    script:
        "../scripts/take_bar.py"


job(
    "take_bar_twin",
    of="recording",
    script="take_bar",
    only={"recording": RECORDINGS.pattern(source="twin", about="bar")},
    output={"truth": of_recording("truth.json"), **BAR_TAKE},
    mem_mb=memory(1000, arrays=12),
    runtime=minutes(30, seconds=2.5),
    params=READ_AS_BAR | {"twin": twin_of(TWINS)},
    message="simulating a bar",
)
promised(BAR_TAKE.values(), ABOUT_BAR)
FILTERS = [of_recording("noise_ros.yaml"), of_recording("px4.params")]
BAR = job(
    "bar",
    of="recording",
    only={"recording": RECORDINGS.pattern(about="bar")},
    input=BAR_TAKE,
    output={
        **figure_of_recording("bar", "bar: errors of a length that moves"),
        "json": of_recording("bar.json"),
        "csv": of_recording("bar.csv"),
        "places": of_recording("bar_places.csv"),
        "verdict": of_recording("verdict.json"),
        "filters": FILTERS,
    },
    mem_mb=memory(1000, arrays=12),
    runtime=minutes(30, seconds=3.0),
    params={"caption": captions.BAR, "row": ROW, "settings": settings("bar", "place")},
    message="errors of a bar that is moved",
)
promised(BAR, ABOUT_BAR)

# Priority, because it is the longest job of a recording and should not run last and alone.
NOISE_OUTPUT = job(
    "noise",
    of="recording",
    input={"trajectories": CLEANED["trajectories"], "clean": CLEANED["clean"]},
    output={
        "allan": of_recording("allan.parquet"),
        "psd": of_recording("psd.parquet"),
        "gaussian": of_recording("gaussian.csv"),
        "covariance": of_recording("covariance.csv"),
        "noise": of_recording("noise.csv"),
        "masked": of_recording("allan_masked.parquet"),
        "periodogram": of_recording("periodogram.parquet"),
    },
    priority=5,
    mem_mb=memory(1000, arrays=9),
    runtime=minutes(120, seconds=5),
    params={
        "subset": of_row(selection.subset_of_paper),
        "settings": settings("psd", "gaussian", *NOISE),
    },
    message="Allan deviations, spectrum, noise coefficients",
)
promised(NOISE_OUTPUT, ABOUT_NOISE)
# In the report the first figure alone: all would be three quarters of it
ON_THE_PAGE = ("verdict.png", "adev.svg", "adev.png", "trajectory.svg", "trajectory.png")
ON_THE_PAGE += ("diagnosis.json", "events.csv", "periodic.csv", "filters.csv")
ON_THE_PAGE += ("diagnosis.svg", "diagnosis.png")
VERDICT = job(
    "verdict",
    of="recording",
    input={"cleaned": list(CLEANED.values()), "noise": NOISE_OUTPUT},
    output={
        "svg": figure_of_recording("verdict", "verdict: uncertainties, limits, causes")["svg"],
        "files": [*map(of_recording, ON_THE_PAGE), *FILTERS],
        "json": of_recording("verdict.json"),
        "fits": directory(of_recording("fit")),
    },
    mem_mb=memory(1000, arrays=9),
    runtime=minutes(30, seconds=3.5),
    params={
        "captions": [captions.VERDICT, captions.DIAGNOSIS],
        "row": ROW,
        "settings": settings("diagnosis", "still", "verdict", allan=["confidence"]),
        "fits": config["fit_figures"],
    },
    message="diagnosis, verdict and figures",
)
promised(VERDICT, ABOUT_NOISE)

# What only some recordings have, or is made on demand: snakemake results/recordings/<name>/fits
further = partial(
    job, of="recording", mem_mb=memory(1000, arrays=12), runtime=minutes(30, seconds=3.0)
)
further(
    "fits",
    input={"results": NOISE_OUTPUT, "noise": of_recording("noise.csv")},
    output={"folder": directory(of_recording("fits"))},
    message="fits of the noise model to every series",
)
ORIENTATION = further(
    "orientation",
    input={
        "trajectories": CLEANED["trajectories"],
        "poses": branch(of_row(has_bodies), then=MEASURED_FILES),
    },
    output={
        "series": of_recording("orientation.parquet"),
        "allan": of_recording("allan_orientation.parquet"),
        "csv": of_recording("orientation.csv"),
        **figure_of_recording("orientation", "orientation: Allan deviation of a rotation vector"),
    },
    params={
        "caption": captions.ORIENTATION,
        "contents": contents(selection.paths),
        "cluster": cell("cluster"),
        "accept_truncated": cell("accept_truncated"),
        "names": cell("column_names"),
        "allan": config["allan"],
        "hampel": config["hampel"],
        "mask_sigma": config["noise"]["mask_sigma"],
    },
    message="noise of the orientation",
)
promised(ORIENTATION, ABOUT_NOISE, turned, "figures")
further(
    "monitor_take",
    input={"cleaned": list(CLEANED.values())},
    output={"json": of_recording("monitor_take.json")},
    params={"settings": settings(monitor=["wander_s"])},
    message="numbers for the monitor",
)
PLACE = further(
    "place",
    input={"clean": CLEANED["clean"]},
    output={
        "csv": of_recording("place.csv"),
        "md": of_recording("place.md"),
        **figure_of_recording("place", "by place: length of a moving pair over the volume"),
    },
    params={"caption": captions.PLACE, "place": config["place"]},
    message="noise by place",
)
promised(PLACE, ABOUT_NOISE, moved, "figures")
