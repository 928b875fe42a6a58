# What both papers say, held against their own tables and against what was regenerated.

JANSEN_TWINS = f"{JANSEN} and source == 'twin'"


rule claims:
    input:
        allan=collect(
            "<results>/recordings/{row.recording}/allan.parquet", row=accepted(query=SKUROWSKI)
        ),
        noise=collect(
            "<results>/recordings/{row.recording}/noise.csv", row=accepted(query=SKUROWSKI)
        ),
        gaussian=collect(
            "<results>/recordings/{row.recording}/gaussian.csv", row=accepted(query=SKUROWSKI)
        ),
        shocked=collect(
            "<results>/recordings/{row.recording}/clean.parquet",
            row=accepted(selection.first, CRUMP),
        ),
        repaired=collect(
            "<results>/recordings/{row.recording}/noise.csv", row=accepted(query=REPAIRED)
        ),
        poses=collect(
            "<results>/calibrations/{row.calibration}/pose.json",
            row=accepted_calibrations(query=JANSEN),
        ),
        truth=collect(
            "<results>/calibrations/{row.calibration}/truth.json",
            row=accepted_calibrations(query=JANSEN_TWINS),
        ),
        sweeps=collect(
            "<results>/calibrations/{row.calibration}/sweeps.parquet",
            row=accepted_calibrations(selection.first_of_setups, JANSEN_TWINS),
        ),
        boards=collect(
            "<results>/calibrations/{row.calibration}/board.csv",
            row=accepted_calibrations(selection.first_of_setups, JANSEN_TWINS),
        ),
        truth_of_first=collect(
            "<results>/calibrations/{row.calibration}/truth.json",
            row=accepted_calibrations(selection.first_of_setups, JANSEN_TWINS),
        ),
    output:
        csv="<results>/tables/claims.csv",
        md="<results>/tables/claims.md",
    log:
        "<logs>/claims.log",
    benchmark:
        "<benchmarks>/claims.tsv"
    resources:
        mem_mb=memory(1500),
        runtime=minutes(60),
    params:
        code=source(
            "claims.py",
            "calibration_records.py",
            "coordinates.py",
            "noise",
            "lighthouse",
            "present",
        ),
        recordings=columns(
            "recording", "source", "camera_type", "n_cameras", of=accepted(query=SKUROWSKI)
        ),
        repaired=columns("recording", of=accepted(query=REPAIRED)),
        calibrations=columns(
            "calibration", "setup", "source", of=accepted_calibrations(query=JANSEN)
        ),
        moved=accepted_calibrations(selection.names, JANSEN_TWINS),
        twins=accepted(settings_by_name, SKUROWSKI),
        hampel=config["hampel"],
    message:
        "Claims of both papers"
    script:
        "../scripts/claims.py"


# Where there is a recording or a calibration of a paper's group.
rule claims_results:
    input:
        tables=branch(
            together(accepted(query=SKUROWSKI), accepted_calibrations(query=JANSEN)),
            then=["<results>/tables/claims.csv", "<results>/tables/claims.md"],
        ),
    localrule: True
