# A calibration is two jobs: sweeps, pose. Twins are simulated and calibrated a setup a job.

LABELS = ("reference_labels_master", "reference_labels_slave", "reference_unit")
ENTRIES = ("calibration", "twin", "format", "board", *LABELS, "tracked_with", "known_length")
# Whether recordings of a setup are joined changes none of them.
LIGHTHOUSE = {name: value for name, value in config["lighthouse"].items() if name != "joint"}
FOLDER = "<results>/calibrations/{calibration}"


# A refusal is a result: this rule succeeds, check.json states the reason, and tables are empty.
checkpoint sweeps:
    input:
        unpack(files(selection.decoded_from)),
    output:
        **tables(DECODED),
        check=f"{FOLDER}/check.json",
    log:
        "<logs>/sweeps/{calibration}.log",
    benchmark:
        "<benchmarks>/sweeps/{calibration}.tsv"
    wildcard_constraints:
        calibration=CALIBRATIONS.pattern(source="measured"),
    resources:
        mem_mb=memory(1500),
        runtime=minutes(30),
    params:
        code=source("sweeps.py"),
        contents=contents(selection.decoded_files),
        row=columns("calibration", "twin", "path", "sha256", "format", "board", "known_length"),
        lighthouse=LIGHTHOUSE,
    message:
        "{wildcards.calibration}: checking and decoding"
    script:
        "../scripts/sweeps.py"


of_calibration = partial(
    job,
    of="calibration",
    only={"calibration": CALIBRATIONS.pattern(source="measured")},
    runtime=minutes(30),
)
of_calibration(
    "pose",
    unpacked=[files(selection.compared_with), of_row(stations_for), of_row(objects_beside)],
    input=tables(DECODED),
    output={
        "figures": figures_of_calibration(),
        **tables(ESTIMATED),
        "allan": f"{FOLDER}/allan.parquet",
    },
    priority=5,
    mem_mb=memory(1000),
    params={
        "caption": captions.CALIBRATION_EITHER,
        "contents": contents(selection.compared_files),
        "row": columns(*ENTRIES),
        "beside": entries_beside(*ENTRIES),
        "lighthouse": LIGHTHOUSE,
        "allan": config["allan"],
    },
    message="calibrating",
)
of_calibration(
    "calibration_bar",
    unpacked=[of_row(bar_of)],
    input=tables(DECODED | {"pose": ESTIMATED["pose"]}),
    output=tables(BAR_OF_CALIBRATION),
    mem_mb=memory(1500),
    params={
        "contents": contents(selection.decoded_files),
        "row": columns(*ENTRIES),
        "bar": columns("bar", "length_mm", "length_u_mm", "bar_pose"),
        "other": of_row(other_end),
        "lighthouse": LIGHTHOUSE,
        "limits": config["bar"],
    },
    message="errors of the length of a bar",
)
of_calibration(
    "calibration_receiver",
    unpacked=[of_row(receiver_of)],
    input=tables(DECODED | {name: ESTIMATED[name] for name in ("pose", "track")}),
    output=tables(RECEIVER),
    mem_mb=memory(1000),
    params={
        "contents": contents(selection.seen_by),
        "row": columns(*ENTRIES),
        "receiver": columns("receiver_labels", "receiver_unit"),
        "lighthouse": LIGHTHOUSE,
    },
    message="against motion capture of its receiver",
)
# Of a twin on demand, or of the first of its setup.
job(
    "calibration_figures",
    of="calibration",
    only={"calibration": CALIBRATIONS.pattern(source="twin")},
    input=tables(DECODED | ESTIMATED),
    output={"figures": figures_of_calibration()},
    mem_mb=memory(1000),
    params={"caption": captions.CALIBRATION_EITHER, "twin": cell("twin")},
    message="figures",
)
# All recordings of a setup in one estimate.
job(
    "calibrate_setup",
    place="calibrate_setup/{group}/{setup}",
    input={
        name: of_each(file, accepted_calibrations(query=OF_SETUP), CALIBRATIONS)
        for name, file in (DECODED | ESTIMATED).items()
        if name in ("sweeps", "inertial", "stations", "board", "pose")
    },
    output={"pose": "<results>/setups/{group}/{setup}/pose.json"},
    mem_mb=memory(1500),
    runtime=minutes(30),
    params={
        "names": accepted_calibrations(selection.names, OF_SETUP),
        "lighthouse": LIGHTHOUSE,
    },
    message="Setup {wildcards.setup} of {wildcards.group}: all recordings in one estimate",
)
for_groups(
    "calibration_tables",
    of=groups(sheet=CALIBRATIONS),
    input={
        "checks": checks(CALIBRATIONS, OF_GROUP),
        "poses": of_each("pose.json", accepted_calibrations(), CALIBRATIONS),
        "tracks": of_each("track.parquet", accepted_calibrations(), CALIBRATIONS),
        "allan": of_each("allan.parquet", accepted_calibrations(at_rest), CALIBRATIONS),
        "setups": poses_of_setups(),
    },
    tables=dict.fromkeys(("calibrations", "track", "angles"), TABLE),
    local=True,
    params={
        "rows": columns("calibration", "setup", "source", of=accepted_calibrations()),
        "at_rest": columns("calibration", "setup", "source", of=accepted_calibrations(at_rest)),
        "setups": setups(),
    },
    message="tables of calibrations",
)


for NUMBER, BATCH in enumerate(selection.batches(CALIBRATIONS.rows.values()), start=1):
    job(
        f"calibration_twins_{NUMBER}",
        script="calibration_twins",
        place=f"calibration_twins/{BATCH[0].name}",
        input={"against": lambda wildcards, rows=BATCH: [path for *_, path in against(rows)]},
        output={"files": [path for row in BATCH for path in results_of_calibration(row)]},
        mem_mb=memory(1000),
        runtime=minutes(30),
        params={
            "contents": [list(map(CONTENTS.get, selection.compared_files(row))) for row in BATCH],
            "rows": [{name: getattr(row, name) for name in ENTRIES} for row in BATCH],
            "at_rest": selection.names(at_rest(BATCH)),
            "against": lambda wildcards, rows=BATCH: [one[:2] for one in against(rows)],
            "twins": {row.twin: CALIBRATION_TWINS[row.twin] for row in BATCH},
            "lighthouse": LIGHTHOUSE,
            "allan": config["allan"],
            "seed": config["seed"],
        },
        message=f"Setup {BATCH[0].setup}: simulating and calibrating {len(BATCH)} recordings",
    )


promise(
    calibrations=together(
        lambda wildcards: [
            path for row in EVERY_CALIBRATION(wildcards) for path in results_of_calibration(row)
        ],
        poses_of_setups(EVERY),
    ),
    figures=collect(
        "<results>/calibrations/{row.calibration}/{figure}.{kind}",
        figure=("calibration", "track"),
        row=accepted_calibrations(selection.shown, EVERY),
        kind=FIGURE,
    ),
)
