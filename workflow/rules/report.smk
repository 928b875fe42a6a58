# Parts of the report besides figures: tables as pages, the summary, provenance.


# One page for each table, recording, calibration, group and paper, and the summary.
rule pages:
    input:
        results=results_of("recordings", "calibrations", "tables", "figures"),
        checks=checks(RECORDINGS) + checks(CALIBRATIONS),
    output:
        # With the category and labels of the table's title
        tables=report(
            directory("<results>/pages"),
            patterns=["{table}.html"],
            caption="../report/caption.rst",
            category=entry("category"),
            subcategory=entry("subcategory"),
            labels=entry("labels"),
        ),
        summary=report(
            "<results>/summary.html",
            caption="../report/summary.rst",
            category="1 Summary",
            labels={"result": "Verdicts: every recording and calibration"},
        ),
        front="<results>/report_front.html",
        svg="<results>/figures/recordings.svg",
        png="<results>/figures/recordings.png",
        details=directory("<results>/details"),
    log:
        "<logs>/pages.log",
    resources:
        **cost(500, 10),
    params:
        code=source("pages.py"),
        caption=captions.TABLE,
        summary=captions.SUMMARY,
        recordings=columns("recording", "group", of=EVERY_RECORDING),
        calibrations=columns("calibration", "setup", "group", "source", of=EVERY_CALIBRATION),
        subjects=subjects,
        papers=papers,
    message:
        "Pages of tables, recordings, calibrations, groups and papers, and the summary"
    script:
        "../scripts/pages.py"


# After everything else, so that all run times are known.
rule provenance:
    input:
        pages=rules.pages.output,  # whose inputs are all results
        tables=results_of("tables"),
        origins=together(
            lambda wildcards: [
                f"{config['results']}/recordings/{row.name}/"
                f"{'bar' if row.bar else 'trajectories'}.parquet"
                for row in EVERY_RECORDING(wildcards)
            ],
            collect("<results>/calibrations/{row.calibration}/pose.json", row=EVERY_CALIBRATION),
        ),
    output:
        page=listed(
            "<results>/provenance.html",
            "7 Provenance",
            "Provenance: versions, seeds, checksums, run times",
        ),
        json="<results>/provenance.json",
    log:
        "<logs>/provenance.log",
    resources:
        **cost(500, 10),
    params:
        code=source("provenance.py"),
        caption=captions.PROVENANCE,
        configuration=reporting.plain_configuration(config),
        inputs=together(
            accepted(partial(reporting.inputs, twins=TWINS), EVERY),
            accepted_calibrations(partial(reporting.inputs, twins=CALIBRATION_TWINS), EVERY),
        ),
        names=[
            *RECORDINGS.rows,
            *CALIBRATIONS.rows,
            *RECORDINGS.groups,
            *CALIBRATIONS.groups,
            *CASES,
        ],
        pages=["pages", "provenance"],
        benchmarks=f"{config['results']}/benchmarks",
    message:
        "Provenance"
    script:
        "../scripts/provenance.py"


# Nothing is reported of calibrations alone.
PAGES = collect_outputs(rules.pages.output, rules.provenance.output)
promise(pages=branch(EVERY_RECORDING, then=PAGES))
