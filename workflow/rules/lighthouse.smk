# Lighthouse: dump -> pulses, stations, sweeps -> board poses, pose of the slave.

LABELS = ("reference_labels_master", "reference_labels_slave", "reference_unit")
COMPARED = (*LABELS, "tracked_with")
# Whether recordings of a setup are joined changes none of them.
LIGHTHOUSE = {name: value for name, value in config["lighthouse"].items() if name != "joint"}
TWIN_NAME = startup.any_of(row.name for row in CALIBRATIONS.rows.values() if row.twin)
OTHER_NAME = startup.any_of(row.name for row in CALIBRATIONS.rows.values() if not row.twin)


# All steps of a twin are one job, because each step is shorter than another start of Python.
rule calibrate_twin:
    input:
        unpack(files(selection.compared_with)),
        unpack(stations_to_track_with),
    output:
        dump=temp("<results>/calibrations/{calibration}/twin.dump"),
        twin_board="<results>/calibrations/{calibration}/twin_board.csv",
        truth="<results>/calibrations/{calibration}/truth.json",
        reference="<results>/calibrations/{calibration}/twin_reference.c3d",
        mount="<results>/calibrations/{calibration}/twin_mount.csv",
        pulses="<results>/calibrations/{calibration}/pulses.parquet",
        inertial="<results>/calibrations/{calibration}/inertial.parquet",
        stations="<results>/calibrations/{calibration}/stations.json",
        sweeps="<results>/calibrations/{calibration}/sweeps.parquet",
        board="<results>/calibrations/{calibration}/board.csv",
        pose="<results>/calibrations/{calibration}/pose.json",
        poses="<results>/calibrations/{calibration}/poses.parquet",
        track="<results>/calibrations/{calibration}/track.parquet",
        crazyflie="<results>/calibrations/{calibration}/crazyflie.yaml",
        libsurvive="<results>/calibrations/{calibration}/libsurvive.json",
        ros2="<results>/calibrations/{calibration}/ros2_static_transforms.launch.xml",
    log:
        "<logs>/calibrate_twin/{calibration}.log",
    benchmark:
        "<benchmarks>/calibrate_twin/{calibration}.tsv"
    wildcard_constraints:
        calibration=TWIN_NAME,
    resources:
        mem_mb=memory(1000),
        runtime=minutes(30),
    params:
        code=source("calibrate_twin.py", "io", "lighthouse", "pipeline", "present/text"),
        contents=contents(selection.compared_files),
        row=columns("calibration", "twin", "format", "board", *COMPARED),
        twin=twin_of(CALIBRATION_TWINS),
        lighthouse=LIGHTHOUSE,
        seed=config["seed"],
    message:
        "{wildcards.calibration}: simulating and calibrating"
    script:
        "../scripts/calibrate_twin.py"


# A refusal is a result: this rule succeeds, and check.json states the reason. Twins need no check.
checkpoint check_calibration:
    input:
        unpack(files(selection.decoded_from)),
    output:
        "<results>/calibrations/{calibration}/check.json",
    log:
        "<logs>/check_calibration/{calibration}.log",
    benchmark:
        "<benchmarks>/check_calibration/{calibration}.tsv"
    resources:
        mem_mb=memory(1500),
        runtime=minutes(30),
    params:
        code=source("check_calibration.py", "io", "lighthouse", "pipeline"),
        contents=contents(selection.decoded_files),
        row=columns("path", "sha256", "format", "board"),
        lighthouse=LIGHTHOUSE,
    message:
        "{wildcards.calibration}: checking"
    script:
        "../scripts/check_calibration.py"


rule decode:
    input:
        unpack(files(selection.decoded_from)),
        check="<results>/calibrations/{calibration}/check.json",
    output:
        pulses="<results>/calibrations/{calibration}/pulses.parquet",
        inertial="<results>/calibrations/{calibration}/inertial.parquet",
        stations="<results>/calibrations/{calibration}/stations.json",
        sweeps="<results>/calibrations/{calibration}/sweeps.parquet",
        board="<results>/calibrations/{calibration}/board.csv",
    log:
        "<logs>/decode/{calibration}.log",
    benchmark:
        "<benchmarks>/decode/{calibration}.tsv"
    wildcard_constraints:
        calibration=OTHER_NAME,
    resources:
        mem_mb=memory(1000),
        runtime=minutes(30),
    params:
        code=source("decode.py", "io", "lighthouse", "pipeline", "present/text"),
        contents=contents(selection.decoded_files),
        row=columns("calibration", "twin", "path", "format", "board"),
        lighthouse=LIGHTHOUSE,
    message:
        "{wildcards.calibration}: decoding"
    script:
        "../scripts/decode.py"


rule calibrate:
    input:
        unpack(files(selection.compared_with)),
        unpack(stations_to_track_with),
        sweeps="<results>/calibrations/{calibration}/sweeps.parquet",
        inertial="<results>/calibrations/{calibration}/inertial.parquet",
        stations="<results>/calibrations/{calibration}/stations.json",
        board="<results>/calibrations/{calibration}/board.csv",
    output:
        pose="<results>/calibrations/{calibration}/pose.json",
        poses="<results>/calibrations/{calibration}/poses.parquet",
        track="<results>/calibrations/{calibration}/track.parquet",
        crazyflie="<results>/calibrations/{calibration}/crazyflie.yaml",
        libsurvive="<results>/calibrations/{calibration}/libsurvive.json",
        ros2="<results>/calibrations/{calibration}/ros2_static_transforms.launch.xml",
    log:
        "<logs>/calibrate/{calibration}.log",
    benchmark:
        "<benchmarks>/calibrate/{calibration}.tsv"
    wildcard_constraints:
        calibration=OTHER_NAME,
    priority: 5
    resources:
        mem_mb=memory(1000),
        runtime=minutes(30),
    params:
        code=source("calibrate.py", "io", "lighthouse", "pipeline", "present/text"),
        contents=contents(selection.compared_files),
        row=columns(*COMPARED),
        lighthouse=LIGHTHOUSE,
    message:
        "{wildcards.calibration}: calibrating"
    script:
        "../scripts/calibrate.py"


# Of a board at rest; for one that moved, allan.parquet states so. It is known of twins beforehand.
rule angle_noise:
    input:
        sweeps="<results>/calibrations/{calibration}/sweeps.parquet",
        pose="<results>/calibrations/{calibration}/pose.json",
    output:
        "<results>/calibrations/{calibration}/allan.parquet",
    log:
        "<logs>/angle_noise/{calibration}.log",
    benchmark:
        "<benchmarks>/angle_noise/{calibration}.tsv"
    resources:
        mem_mb=memory(500),
        runtime=minutes(10),
    params:
        code=source("angle_noise.py", "lighthouse", "noise", "pipeline"),
        allan=config["allan"],
    message:
        "{wildcards.calibration}: noise of angles"
    script:
        "../scripts/angle_noise.py"


# All recordings of a setup in one estimate.
rule calibrate_setup:
    input:
        sweeps=collect(
            "<results>/calibrations/{row.calibration}/sweeps.parquet",
            row=accepted_calibrations(query=OF_SETUP),
        ),
        inertial=collect(
            "<results>/calibrations/{row.calibration}/inertial.parquet",
            row=accepted_calibrations(query=OF_SETUP),
        ),
        stations=collect(
            "<results>/calibrations/{row.calibration}/stations.json",
            row=accepted_calibrations(query=OF_SETUP),
        ),
        board=collect(
            "<results>/calibrations/{row.calibration}/board.csv",
            row=accepted_calibrations(query=OF_SETUP),
        ),
        pose=collect(
            "<results>/calibrations/{row.calibration}/pose.json",
            row=accepted_calibrations(query=OF_SETUP),
        ),
    output:
        "<results>/setups/{group}/{setup}/pose.json",
    log:
        "<logs>/calibrate_setup/{group}/{setup}.log",
    benchmark:
        "<benchmarks>/calibrate_setup/{group}/{setup}.tsv"
    resources:
        mem_mb=memory(1500),
        runtime=minutes(30),
    params:
        code=source("calibrate_setup.py", "io", "lighthouse", "pipeline", "present/text"),
        names=accepted_calibrations(selection.names, OF_SETUP),
        lighthouse=LIGHTHOUSE,
    message:
        "Setup {wildcards.setup} of {wildcards.group}: all recordings in one estimate"
    script:
        "../scripts/calibrate_setup.py"


rule calibration_figures:
    input:
        unpack(noise_of_angles),
        pose="<results>/calibrations/{calibration}/pose.json",
        poses="<results>/calibrations/{calibration}/poses.parquet",
        sweeps="<results>/calibrations/{calibration}/sweeps.parquet",
        stations="<results>/calibrations/{calibration}/stations.json",
        board="<results>/calibrations/{calibration}/board.csv",
        track="<results>/calibrations/{calibration}/track.parquet",
    output:
        png="<results>/calibrations/{calibration}/calibration.png",
        svg=report(
            "<results>/calibrations/{calibration}/calibration.svg",
            caption="../report/caption.rst",
            category="6 Calibrations",
            labels={"result": "{calibration}: paths, residuals, pose, verdict"},
        ),
        track_png="<results>/calibrations/{calibration}/track.png",
        track_svg=report(
            "<results>/calibrations/{calibration}/track.svg",
            caption="../report/caption.rst",
            category="6 Calibrations",
            labels={"result": "{calibration}: tracked receiver"},
        ),
    log:
        "<logs>/calibration_figures/{calibration}.log",
    benchmark:
        "<benchmarks>/calibration_figures/{calibration}.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(10),
    params:
        code=source("calibration_figures.py", "lighthouse", "present"),
        caption=captions.CALIBRATION_EITHER,
        name=cell("calibration"),
        twin=cell("twin"),
    message:
        "{wildcards.calibration}: figures"
    script:
        "../scripts/calibration_figures.py"


rule calibration_tables:
    input:
        checks=checks(CALIBRATIONS, OF_GROUP),
        poses=collect(
            "<results>/calibrations/{row.calibration}/pose.json", row=accepted_calibrations()
        ),
        tracks=collect(
            "<results>/calibrations/{row.calibration}/track.parquet", row=accepted_calibrations()
        ),
        allan=collect(
            "<results>/calibrations/{row.calibration}/allan.parquet",
            row=accepted_calibrations(at_rest),
        ),
        setups=poses_of_setups(),
    output:
        multiext("<results>/tables/{group}_calibrations", ".csv", ".md"),
        multiext("<results>/tables/{group}_track", ".csv", ".md"),
        multiext("<results>/tables/{group}_angles", ".csv", ".md"),
    log:
        "<logs>/calibration_tables/{group}.log",
    benchmark:
        "<benchmarks>/calibration_tables/{group}.tsv"
    localrule: True
    resources:
        mem_mb=memory(500),
        runtime=minutes(10),
    params:
        code=source("calibration_tables.py", "calibration_records.py", "lighthouse", "present"),
        rows=columns("calibration", "setup", "source", of=accepted_calibrations()),
        at_rest=columns("calibration", "setup", "source", of=accepted_calibrations(at_rest)),
        setups=setups(),
    message:
        "{wildcards.group}: tables of calibrations"
    script:
        "../scripts/calibration_tables.py"


rule lighthouse_results:
    input:
        calibrations=together(
            collect_outputs(
                rules.calibrate_twin.output[1:],  # without the dump
                calibration=accepted_calibrations(selection.names, SIMULATED),
            ),
            collect_outputs(
                rules.decode.output,
                rules.calibrate.output,
                calibration=accepted_calibrations(selection.names, MEASURED),
            ),
            collect(
                "<results>/calibrations/{row.calibration}/allan.parquet",
                row=accepted_calibrations(at_rest, EVERY),
            ),
            poses_of_setups(EVERY),
        ),
        tables=collect(
            "<results>/tables/{group}_{table}.{kind}",
            table=("calibrations", "track", "angles"),
            group=groups(sheet=CALIBRATIONS),
            kind=TABLE,
        ),
        figures=collect(
            "<results>/calibrations/{row.calibration}/{figure}.{kind}",
            figure=("calibration", "track"),
            row=accepted_calibrations(selection.shown, EVERY),
            kind=FIGURE,
        ),
