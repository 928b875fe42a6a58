# What both papers say, held against their own tables and against what was regenerated.


rule claims:
    input:
        allan=of_paper("allan.parquet"),
        noise=of_paper("noise.csv"),
        gaussian=of_paper("gaussian.csv"),
        shocked=lambda wildcards: [
            f"<results>/recordings/{name}/clean.parquet" for name in shocked()
        ],
        repaired=lambda wildcards: [f"<results>/recordings/{name}/noise.csv" for name in repaired()],
        poses=of_calibrations("pose.json", "jansen2019"),
        truth=lambda wildcards: [of_calibration(name, "truth.json") for name in moved_twins()],
        sweeps=lambda wildcards: [
            of_calibration(name, "sweeps.parquet") for name in first_of_setups()
        ],
        boards=lambda wildcards: [of_calibration(name, "board.csv") for name in first_of_setups()],
        truth_of_first=lambda wildcards: [
            of_calibration(name, "truth.json") for name in first_of_setups()
        ],
    output:
        csv="<results>/tables/claims.csv",
        md="<results>/tables/claims.md",
    log:
        "<logs>/claims.log",
    benchmark:
        "<benchmarks>/claims.tsv"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        code=source(
            "claims.py",
            "calibration_records.py",
            "coordinates.py",
            "noise",
            "lighthouse",
            "present",
        ),
        recordings=lambda wildcards: columns_of(
            accepted_rows("skurowski2019"), "recording", "source", "camera_type", "n_cameras"
        ),
        repaired=lambda wildcards: columns_of(map(row, repaired()), "recording"),
        calibrations=lambda wildcards: records(accepted_calibrations("jansen2019")),
        moved=lambda wildcards: moved_twins(),
        twins=lambda wildcards: twins_of_paper(),
        hampel=config["hampel"],
    message:
        "Claims of both papers"
    script:
        "../scripts/claims.py"
