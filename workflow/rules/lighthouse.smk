# Lighthouse: dump -> pulses, stations, sweeps -> board poses, pose of the slave.


rule simulate_calibration:
    output:
        dump=temp("<results>/calibrations/{calibration}/twin.dump"),
        board="<results>/calibrations/{calibration}/twin_board.csv",
        truth="<results>/calibrations/{calibration}/truth.json",
        reference="<results>/calibrations/{calibration}/twin_reference.c3d",
        mount="<results>/calibrations/{calibration}/twin_mount.csv",
    log:
        "<logs>/simulate_calibration/{calibration}.log",
    benchmark:
        "<benchmarks>/simulate_calibration/{calibration}.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        code=digest("simulate_calibration.py"),
        row=calibration_row,
        twin=calibration_twin_settings,
        seed=config["seed"],
    message:
        "{wildcards.calibration}: simulating"
    script:
        "../scripts/simulate_calibration.py"


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
        code=digest("check_calibration.py"),
        row=calibration_row,
        lighthouse=config["lighthouse"],
    message:
        "{wildcards.calibration}: checking"
    script:
        "../scripts/check_calibration.py"


# Before other simulations, so that few raw twins lie on the disk at any time.
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
    priority: 10
    threads: 1
    resources:
        mem_mb=1000,
    params:
        code=digest("decode.py"),
        row=calibration_row,
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
    priority: 5
    threads: 1
    resources:
        mem_mb=1000,
    params:
        code=digest("calibrate.py"),
        row=calibration_row,
        lighthouse=config["lighthouse"],
    message:
        "{wildcards.calibration}: calibrating"
    script:
        "../scripts/calibrate.py"
