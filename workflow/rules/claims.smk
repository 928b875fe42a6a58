# Claims of both papers, tested with their own tables and with regenerated results.

JANSEN_TWINS = f"{JANSEN} and {SIMULATED}"  # their motion is known
TWINS_OF_JANSEN = accepted_calibrations(query=JANSEN_TWINS)
SETUPS = accepted_calibrations(selection.first_of_setups, JANSEN_TWINS)


rule claims:
    input:
        allan=collect("<results>/recordings/{row.recording}/allan.parquet", row=OF_SKUROWSKI),
        noise=collect("<results>/recordings/{row.recording}/noise.csv", row=OF_SKUROWSKI),
        gaussian=collect("<results>/recordings/{row.recording}/gaussian.csv", row=OF_SKUROWSKI),
        shocked=collect("<results>/recordings/{row.recording}/clean.parquet", row=SHAKEN),
        repaired=collect("<results>/recordings/{row.recording}/noise.csv", row=OF_REPAIRED),
        poses=collect("<results>/calibrations/{row.calibration}/pose.json", row=OF_JANSEN),
        truth=collect("<results>/calibrations/{row.calibration}/truth.json", row=TWINS_OF_JANSEN),
        sweeps=collect("<results>/calibrations/{row.calibration}/sweeps.parquet", row=SETUPS),
        boards=collect("<results>/calibrations/{row.calibration}/board.csv", row=SETUPS),
        truth_of_first=collect("<results>/calibrations/{row.calibration}/truth.json", row=SETUPS),
    output:
        csv="<results>/tables/claims.csv",
        md="<results>/tables/claims.md",
    log:
        "<logs>/claims.log",
    benchmark:
        "<benchmarks>/claims.tsv"
    resources:
        mem_mb=memory(1500),
        runtime=minutes(30),
    params:
        code=source(
            "claims.py",
            "calibration_records.py",
            "coordinates.py",
            "noise",
            "lighthouse",
            "present",
        ),
        recordings=columns("recording", "source", "camera_type", "n_cameras", of=OF_SKUROWSKI),
        repaired=columns("recording", of=OF_REPAIRED),
        calibrations=columns("calibration", "setup", "source", of=OF_JANSEN),
        moved=accepted_calibrations(selection.names, JANSEN_TWINS),
        twins=TWINS_OF_PAPER,
        hampel=config["hampel"],
    message:
        "Claims of both papers"
    script:
        "../scripts/claims.py"


# Only with a recording or a calibration of a paper's group.
rule claims_results:
    input:
        tables=branch(together(OF_SKUROWSKI, OF_JANSEN), then=collect_outputs(rules.claims.output)),
