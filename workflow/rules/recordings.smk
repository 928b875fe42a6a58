# A recording is three jobs: clean, noise, verdict. Parquet between them is the cache: a changed
# setting of the noise reads no recording, a changed caption fits no noise. Of a bar that is moved
# there are two: take_bar, bar.

CLEANED = [
    "<results>/recordings/{recording}/trajectories.parquet",
    "<results>/recordings/{recording}/clean.parquet",
    "<results>/recordings/{recording}/outliers.csv",
]
MEASURED_FILES = files(selection.paths)
ENTRY = ("markers", "frame_rate_hz", "accept_truncated", "unit", "column_names")
ORIGIN = ("recording", "source", "twin", "pairs")  # what tables are marked with
OF_BAR = ("bar", "length_mm", "length_u_mm", "bar_pose")
PICTURES = ("verdict", "adev", "trajectory", "diagnosis")
BAR_TAKE = "<results>/recordings/{recording}/bar.parquet"
READ_AS_BAR = {  # params of both rules
    "code": source("take_bar.py"),
    "entry": columns(*ENTRY),
    "origin": columns("recording", "source", "twin", "date"),
    "bar": columns(*OF_BAR),
    "settings": settings("seed", "second_opinion", bar=["rigid_mm", "least_path_mm"]),
}


# A refusal is a result: this rule succeeds, check.json states the reason, and tables are empty.
checkpoint clean:
    input:
        MEASURED_FILES,
    output:
        check="<results>/recordings/{recording}/check.json",
        trajectories=CLEANED[0],
        clean=CLEANED[1],
        outliers=CLEANED[2],
    log:
        "<logs>/clean/{recording}.log",
    wildcard_constraints:
        recording=RECORDINGS.pattern(source="measured", about="noise"),
    priority: 10
    resources:
        **cost(4000, 30, arrays=9, seconds=2.5),
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
rule clean_twin:
    output:
        truth="<results>/recordings/{recording}/truth.json",
        trajectories=CLEANED[0],
        clean=CLEANED[1],
        outliers=CLEANED[2],
    log:
        "<logs>/clean/{recording}.log",
    wildcard_constraints:
        recording=RECORDINGS.pattern(source="twin", about="noise"),
    resources:
        **cost(1000, 30, arrays=9, seconds=2.5),
    params:
        code=source("clean.py"),
        entry=columns(*ENTRY),
        origin=of_row(
            lambda row: {name: getattr(row, name) for name in ORIGIN}
            | {"form": selection.form(row, TWINS)}
        ),
        twin=twin_of(TWINS),
        settings=settings("hampel", "seed"),
    message:
        "{wildcards.recording}: simulating and cleaning"
    script:
        "../scripts/clean.py"


# As `clean` of a bar that is moved. Its noise is no noise: nothing is cleaned or fitted.
checkpoint take_bar:
    input:
        MEASURED_FILES,
    output:
        check="<results>/recordings/{recording}/check.json",
        take=BAR_TAKE,
    log:
        "<logs>/take_bar/{recording}.log",
    wildcard_constraints:
        recording=RECORDINGS.pattern(source="measured", about="bar"),
    priority: 10
    resources:
        **cost(2000, 30, arrays=12, seconds=2.5),
    params:
        **READ_AS_BAR,
        contents=contents(selection.paths),
        paths=cell("paths"),
        sha256=cell("sha256"),
    message:
        "{wildcards.recording}: reading the bar"
    script:
        "../scripts/take_bar.py"


rule take_bar_twin:
    output:
        truth="<results>/recordings/{recording}/truth.json",
        take=BAR_TAKE,
    log:
        "<logs>/take_bar/{recording}.log",
    wildcard_constraints:
        recording=RECORDINGS.pattern(source="twin", about="bar"),
    resources:
        **cost(1000, 30, arrays=12, seconds=2.5),
    params:
        **READ_AS_BAR,
        twin=twin_of(TWINS),
    message:
        "{wildcards.recording}: simulating a bar"
    script:
        "../scripts/take_bar.py"


rule bar:
    input:
        take=BAR_TAKE,
    output:
        **figure_of_recording("bar", "bar: errors of a length that moves"),
        json=of_recording("bar.json"),
        csv=of_recording("bar.csv"),
        places=of_recording("bar_places.csv"),
        verdict=of_recording("verdict.json"),
        filters=multiext("<results>/recordings/{recording}/", "noise_ros.yaml", "px4.params"),
    log:
        "<logs>/bar/{recording}.log",
    wildcard_constraints:
        recording=RECORDINGS.pattern(about="bar"),
    resources:
        **cost(1000, 30, arrays=12, seconds=3.0),
    params:
        code=source("bar.py"),
        caption=captions.BAR,
        row=columns("recording", "group", "twin", "camera_type", "n_cameras"),
        settings=settings("bar", "place"),
    message:
        "{wildcards.recording}: errors of a bar that is moved"
    script:
        "../scripts/bar.py"


# Priority, because it is the longest job of a recording and should not run last and alone.
rule noise:
    input:
        CLEANED[:2],
    output:
        allan="<results>/recordings/{recording}/allan.parquet",
        psd="<results>/recordings/{recording}/psd.parquet",
        gaussian="<results>/recordings/{recording}/gaussian.csv",
        covariance="<results>/recordings/{recording}/covariance.csv",
        noise="<results>/recordings/{recording}/noise.csv",
        masked="<results>/recordings/{recording}/allan_masked.parquet",
        periodogram="<results>/recordings/{recording}/periodogram.parquet",
    log:
        "<logs>/noise/{recording}.log",
    priority: 5
    resources:
        **cost(1000, 120, arrays=9, seconds=5),
    params:
        code=source("noise.py"),
        subset=of_row(selection.subset_of_paper),
        settings=settings("psd", "gaussian", *NOISE),
    message:
        "{wildcards.recording}: Allan deviations, spectrum, noise coefficients"
    script:
        "../scripts/noise.py"


rule verdict:
    input:
        CLEANED,
        rules.noise.output,
    output:
        figure_of_recording("verdict", "verdict: uncertainties, limits, causes")["svg"],
        # On the page of the recording only: in the report they would be three quarters of it
        collect(
            "<results>/recordings/{{recording}}/{file}",
            file=[
                *(f"{name}.svg" for name in PICTURES if name != "verdict"),
                *(f"{name}.png" for name in PICTURES if config["png"]),
                *("diagnosis.json", "events.csv", "periodic.csv", "filters.csv"),
                *("noise_ros.yaml", "px4.params"),
            ],
        ),
        json="<results>/recordings/{recording}/verdict.json",
        fits=directory("<results>/recordings/{recording}/fit"),
    log:
        "<logs>/verdict/{recording}.log",
    resources:
        **cost(1000, 30, arrays=9, seconds=3.5),
    params:
        code=source("verdict.py"),
        captions=[captions.VERDICT, captions.DIAGNOSIS],
        row=columns("recording", "group", "twin", "camera_type", "n_cameras"),
        settings=settings("diagnosis", "still", "verdict", allan=["confidence"]),
        fits=config["fit_figures"],
        png=config["png"],
    message:
        "{wildcards.recording}: diagnosis, verdict and figures"
    script:
        "../scripts/verdict.py"


# What only some recordings have, or is made on demand: snakemake results/recordings/<name>/fits
FURTHER = {
    "fits": {
        "input": {"results": rules.noise.output, "noise": of_recording("noise.csv")},
        "output": {"folder": directory(of_recording("fits"))},
        "params": {},
        "message": "fits of the noise model to every series",
    },
    "orientation": {
        "input": {
            "trajectories": CLEANED[0],
            "poses": branch(of_row(has_bodies), then=MEASURED_FILES),
        },
        "output": {
            "series": of_recording("orientation.parquet"),
            "allan": of_recording("allan_orientation.parquet"),
            "csv": of_recording("orientation.csv"),
            **figure_of_recording(
                "orientation", "orientation: Allan deviation of a rotation vector"
            ),
        },
        "params": {
            "caption": captions.ORIENTATION,
            "contents": contents(selection.paths),
            "cluster": cell("cluster"),
            "accept_truncated": cell("accept_truncated"),
            "names": cell("column_names"),
            "allan": config["allan"],
            "hampel": config["hampel"],
            "mask_sigma": config["noise"]["mask_sigma"],
        },
        "message": "noise of the orientation",
    },
    "monitor_take": {
        "input": {"cleaned": CLEANED},
        "output": {"json": of_recording("monitor_take.json")},
        "params": {"settings": settings(monitor=["wander_s"])},
        "message": "numbers for the monitor",
    },
    "place": {
        "input": {"clean": CLEANED[1]},
        "output": {
            "csv": of_recording("place.csv"),
            "md": of_recording("place.md"),
            **figure_of_recording("place", "by place: length of a moving pair over the volume"),
        },
        "params": {"caption": captions.PLACE, "place": config["place"]},
        "message": "noise by place",
    },
}

for NAME, OF in FURTHER.items():

    rule:
        name:
            NAME
        input:
            **OF["input"],
        output:
            **OF["output"],
        log:
            f"<logs>/{NAME}/{{recording}}.log",
        resources:
            **cost(1000, 30, arrays=12, seconds=3.0),
        params:
            **OF["params"],
            code=source(f"{NAME}.py"),
            script=NAME,
        message:
            f"{{wildcards.recording}}: {OF['message']}"
        script:
            "../scripts/{params.script}.py"  # by name: NAME is the last one when a job runs


promise(
    recordings=together(
        collect(
            "<results>/recordings/{row.recording}/truth.json",
            row=accepted(query=SIMULATED),
        ),
        collect_outputs(
            CLEANED,
            rules.noise.output,
            rules.verdict.output,
            recording=accepted(selection.names, ABOUT_NOISE),
        ),
        collect_outputs(
            [BAR_TAKE], rules.bar.output, recording=accepted(selection.names, ABOUT_BAR)
        ),
    ),
    figures=together(
        collect_outputs(rules.orientation.output, recording=accepted(turned, ABOUT_NOISE)),
        collect_outputs(rules.place.output, recording=accepted(moved, ABOUT_NOISE)),
    ),
)
