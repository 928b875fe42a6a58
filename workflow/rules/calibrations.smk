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
        # The check is first: what waits for a checkpoint asks for its first file
        **tables({"check": "check.json"} | DECODED),
    log:
        "<logs>/sweeps/{calibration}.log",
    wildcard_constraints:
        calibration=CALIBRATIONS.pattern(source="measured"),
    resources:
        **cost(1500, 30),
    params:
        code=source("sweeps.py"),
        contents=contents(selection.decoded_from),
        row=columns("calibration", "twin", "path", "sha256", "format", "board", "known_length"),
        lighthouse=LIGHTHOUSE,
    message:
        "{wildcards.calibration}: checking and decoding"
    script:
        "../scripts/sweeps.py"


rule pose:
    input:
        unpack(files(selection.compared_with)),
        unpack(of_row(stations_for)),
        unpack(of_row(objects_beside)),
        **tables(DECODED),
    output:
        **figures_of_calibration(),
        **tables(ESTIMATED),
        allan=f"{FOLDER}/allan.parquet",
    log:
        "<logs>/pose/{calibration}.log",
    wildcard_constraints:
        calibration=CALIBRATIONS.pattern(source="measured"),
    priority: 5
    resources:
        **cost(1000, 30),
    params:
        code=source("pose.py"),
        caption=captions.CALIBRATION_EITHER,
        contents=contents(selection.compared_with),
        row=columns(*ENTRIES),
        beside=entries_beside(*ENTRIES),
        lighthouse=LIGHTHOUSE,
        allan=config["allan"],
    message:
        "{wildcards.calibration}: calibrating"
    script:
        "../scripts/pose.py"


# What only some calibrations have; figures of a twin are made on demand, or of the first of its setup.
FURTHER_OF_CALIBRATION = {
    "calibration_bar": {
        "source": "measured",
        "input": {"pose": ESTIMATED["pose"]},
        "files": bar_of,
        "output": tables(BAR_OF_CALIBRATION),
        "params": {
            "contents": contents(selection.decoded_from),
            "row": columns(*ENTRIES),
            "bar": columns("bar", "length_mm", "length_u_mm", "bar_pose"),
            "other": of_row(other_end),
            "lighthouse": LIGHTHOUSE,
            "limits": config["bar"],
        },
        "message": "errors of the length of a bar",
    },
    "calibration_receiver": {
        "source": "measured",
        "input": {name: ESTIMATED[name] for name in ("pose", "track")},
        "files": receiver_of,
        "output": tables(RECEIVER),
        "params": {
            "contents": contents(selection.seen_by),
            "row": columns(*ENTRIES),
            "receiver": columns("receiver_labels", "receiver_unit"),
            "lighthouse": LIGHTHOUSE,
        },
        "message": "against motion capture of its receiver",
    },
    "calibration_figures": {
        "source": "twin",
        "input": ESTIMATED,
        "files": lambda row: {},
        "output": figures_of_calibration(),
        "params": {"caption": captions.CALIBRATION_EITHER, "twin": cell("twin")},
        "message": "figures",
    },
}

for NAME, OF in FURTHER_OF_CALIBRATION.items():

    rule:
        name:
            NAME
        input:
            unpack(of_row(OF["files"])),
            **tables(DECODED | OF["input"]),
        output:
            **OF["output"],
        log:
            f"<logs>/{NAME}/{{calibration}}.log",
        wildcard_constraints:
            calibration=CALIBRATIONS.pattern(source=OF["source"]),
        resources:
            **cost(1500, 30),
        params:
            **OF["params"],
            code=source(f"{NAME}.py"),
            script=NAME,
        message:
            f"{{wildcards.calibration}}: {OF['message']}"
        script:
            "../scripts/{params.script}.py"  # by name: NAME is the last one when a job runs


for NUMBER, BATCH in enumerate(selection.batches(CALIBRATIONS.rows.values()), start=1):

    rule:
        name:
            f"calibration_twins_{NUMBER}"
        input:
            lambda wildcards, rows=BATCH: [path for *_, path in against(rows)],
        output:
            collect(
                "<results>/calibrations/{row.name}/{file}",
                row=BATCH,
                file=[*DECODED.values(), *ESTIMATED.values()],
            ),
            *(
                collect("<results>/calibrations/{row.name}/{file}", row=of(BATCH), file=names)
                for of, names in TWIN_FILES
            ),
            collect("<results>/calibrations/{row.name}/allan.parquet", row=at_rest(BATCH)),
        log:
            f"<logs>/calibration_twins/{BATCH[0].name}.log",
        resources:
            **cost(1000, 30),
        params:
            code=source("calibration_twins.py"),
            contents=[
                list(map(CONTENTS.get, selection.compared_with(row).values())) for row in BATCH
            ],
            rows=[{name: getattr(row, name) for name in ENTRIES} for row in BATCH],
            at_rest=selection.names(at_rest(BATCH)),
            against=lambda wildcards, rows=BATCH: [one[:2] for one in against(rows)],
            twins={row.twin: CALIBRATION_TWINS[row.twin] for row in BATCH},
            lighthouse=LIGHTHOUSE,
            allan=config["allan"],
            seed=config["seed"],
        message:
            f"Setup {BATCH[0].setup}: simulating and calibrating {len(BATCH)} recordings"
        script:
            "../scripts/calibration_twins.py"


# All recordings of a setup in one estimate.
rule calibrate_setup:
    input:
        **{
            name: of_each(file, accepted_calibrations(query=OF_SETUP), CALIBRATIONS)
            for name, file in (DECODED | ESTIMATED).items()
            if name in ("sweeps", "inertial", "stations", "board", "pose")
        },
    output:
        "<results>/setups/{group}/{setup}/pose.json",
    log:
        "<logs>/calibrate_setup/{group}/{setup}.log",
    resources:
        **cost(1500, 30),
    params:
        code=source("calibrate_setup.py"),
        names=accepted_calibrations(selection.names, OF_SETUP),
        lighthouse=LIGHTHOUSE,
    message:
        "Setup {wildcards.setup} of {wildcards.group}: all recordings in one estimate"
    script:
        "../scripts/calibrate_setup.py"


rule calibration_tables:
    input:
        checks=checks(CALIBRATIONS, OF_GROUP),
        poses=of_each("pose.json", accepted_calibrations(), CALIBRATIONS),
        tracks=of_each("track.parquet", accepted_calibrations(), CALIBRATIONS),
        allan=of_each("allan.parquet", accepted_calibrations(at_rest), CALIBRATIONS),
        setups=poses_of_setups(),
    output:
        tables_of_group("calibrations", "track", "angles"),
    log:
        "<logs>/calibration_tables/{group}.log",
    localrule: True
    resources:
        **cost(500, 10),
    params:
        code=source("calibration_tables.py"),
        rows=columns("calibration", "setup", "source", of=accepted_calibrations()),
        at_rest=columns("calibration", "setup", "source", of=accepted_calibrations(at_rest)),
        setups=setups(),
    message:
        "{wildcards.group}: tables of calibrations"
    script:
        "../scripts/calibration_tables.py"


promise(
    calibrations=together(
        collect(
            "<results>/calibrations/{row.calibration}/{file}",
            row=EVERY_CALIBRATION,
            file=[*DECODED.values(), *ESTIMATED.values()],
        ),
        *(
            of_each(file, accepted_calibrations(of, SIMULATED), CALIBRATIONS)
            for of, names in TWIN_FILES
            for file in names
        ),
        of_each("allan.parquet", accepted_calibrations(at_rest, EVERY), CALIBRATIONS),
        poses_of_setups(EVERY),
        *(
            of_each(file, accepted_calibrations(selection.having("bar"), EVERY), CALIBRATIONS)
            for file in BAR_OF_CALIBRATION.values()
        ),
        of_each(
            "receiver.json",
            accepted_calibrations(selection.having("receiver"), EVERY),
            CALIBRATIONS,
        ),
    ),
    tables=collect(
        tables_of_group("calibrations", "track", "angles"), group=groups(sheet=CALIBRATIONS)
    ),
    figures=collect(
        "<results>/calibrations/{row.calibration}/{figure}.{kind}",
        figure=("calibration", "track"),
        row=accepted_calibrations(selection.shown, EVERY),
        kind=FIGURE,
    ),
)
