# Lighthouse: dump -> pulses, stations, sweeps -> board poses, pose of the slave.

LABELS = ("reference_labels_master", "reference_labels_slave")


# Of a twin, in one job: two seconds of work a step are less than another start of Python takes.
rule calibrate_twin:
    input:
        unpack(reference_files),
    output:
        dump=temp("<results>/calibrations/{calibration}/twin.dump"),
        twin_board="<results>/calibrations/{calibration}/twin_board.csv",
        truth="<results>/calibrations/{calibration}/truth.json",
        reference="<results>/calibrations/{calibration}/twin_reference.c3d",
        mount="<results>/calibrations/{calibration}/twin_mount.csv",
        pulses="<results>/calibrations/{calibration}/pulses.parquet",
        stations="<results>/calibrations/{calibration}/stations.json",
        sweeps="<results>/calibrations/{calibration}/sweeps.parquet",
        board="<results>/calibrations/{calibration}/board.csv",
        pose="<results>/calibrations/{calibration}/pose.json",
        poses="<results>/calibrations/{calibration}/poses.parquet",
    log:
        "<logs>/calibrate_twin/{calibration}.log",
    benchmark:
        "<benchmarks>/calibrate_twin/{calibration}.tsv"
    wildcard_constraints:
        calibration=startup.any_of(calibration_names(twin=True)),
    threads: 1
    resources:
        mem_mb=1000,
    params:
        code=source(
            "calibrate_twin.py", "lighthouse_files.py", "lighthouse_steps.py", "io", "lighthouse"
        ),
        row=columns("calibration", "twin", "format", "board", *LABELS),
        twin=calibration_twin_settings,
        lighthouse=config["lighthouse"],
        seed=config["seed"],
    message:
        "{wildcards.calibration}: simulating and calibrating"
    script:
        "../scripts/calibrate_twin.py"


# A refusal is a result: this rule succeeds, and check.json says why not. Twins need no check.
checkpoint check_calibration:
    input:
        unpack(calibration_files),
    output:
        "<results>/calibrations/{calibration}/check.json",
    log:
        "<logs>/check_calibration/{calibration}.log",
    benchmark:
        "<benchmarks>/check_calibration/{calibration}.tsv"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        code=source("check_calibration.py", "lighthouse_steps.py", "io", "lighthouse"),
        row=columns("path", "sha256", "format", "board"),
        lighthouse=config["lighthouse"],
    message:
        "{wildcards.calibration}: checking"
    script:
        "../scripts/check_calibration.py"


rule decode:
    input:
        unpack(calibration_files),
        check=check_of_calibration,
    output:
        pulses="<results>/calibrations/{calibration}/pulses.parquet",
        stations="<results>/calibrations/{calibration}/stations.json",
        sweeps="<results>/calibrations/{calibration}/sweeps.parquet",
        board="<results>/calibrations/{calibration}/board.csv",
    log:
        "<logs>/decode/{calibration}.log",
    benchmark:
        "<benchmarks>/decode/{calibration}.tsv"
    wildcard_constraints:
        calibration=startup.any_of(calibration_names(twin=False)),
    threads: 1
    resources:
        mem_mb=1000,
    params:
        code=source("decode.py", "lighthouse_files.py", "lighthouse_steps.py", "io", "lighthouse"),
        row=columns("calibration", "twin", "path", "format", "board"),
        lighthouse=config["lighthouse"],
    message:
        "{wildcards.calibration}: decoding"
    script:
        "../scripts/decode.py"


rule calibrate:
    input:
        unpack(reference_files),
        sweeps="<results>/calibrations/{calibration}/sweeps.parquet",
        stations="<results>/calibrations/{calibration}/stations.json",
        board="<results>/calibrations/{calibration}/board.csv",
    output:
        pose="<results>/calibrations/{calibration}/pose.json",
        poses="<results>/calibrations/{calibration}/poses.parquet",
    log:
        "<logs>/calibrate/{calibration}.log",
    benchmark:
        "<benchmarks>/calibrate/{calibration}.tsv"
    wildcard_constraints:
        calibration=startup.any_of(calibration_names(twin=False)),
    priority: 5
    threads: 1
    resources:
        mem_mb=1000,
    params:
        code=source(
            "calibrate.py", "lighthouse_files.py", "lighthouse_steps.py", "io", "lighthouse"
        ),
        row=columns(*LABELS),
        lighthouse=config["lighthouse"],
    message:
        "{wildcards.calibration}: calibrating"
    script:
        "../scripts/calibrate.py"
