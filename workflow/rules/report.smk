# Parts of the report besides figures: tables as pages, the summary, provenance.


# One page for each table, with the category and labels of its title.
rule report_pages:
    input:
        results_of("tables"),
    output:
        report(
            directory("<results>/pages"),
            patterns=["{table}.html"],
            caption="../report/caption.rst",
            category=entry("category"),
            subcategory=entry("subcategory"),
            labels=entry("labels"),
        ),
    log:
        "<logs>/report_pages.log",
    benchmark:
        "<benchmarks>/report_pages.tsv"
    resources:
        mem_mb=memory(500),
        runtime=minutes(10),
    params:
        code=source("report_pages.py", "lighthouse", "present"),
        papers=papers,
        caption=captions.TABLE,
    message:
        "Tables as pages"
    script:
        "../scripts/report_pages.py"


rule summary_page:
    input:
        checks=checks(RECORDINGS) + checks(CALIBRATIONS),
        verdicts=collect("<results>/recordings/{row.recording}/verdict.json", row=EVERY_RECORDING),
        poses=collect("<results>/calibrations/{row.calibration}/pose.json", row=EVERY_CALIBRATION),
        cameras=collect("<results>/tables/{group}_cameras.json", group=groups(selection.subsets)),
        claims=branch(together(OF_SKUROWSKI, OF_JANSEN), then=["<results>/tables/claims.csv"]),
        changes=collect("<results>/tables/{group}_compare.json", group=groups(pairs)),
        compared=lambda wildcards: reporting.of_papers(results_of("tables")(wildcards)),
    output:
        page=report(
            "<results>/summary.html",
            caption="../report/caption.rst",
            category="1 Summary",
            labels={"result": "Verdicts: every recording and calibration"},
        ),
        front="<results>/report_front.html",
        svg="<results>/figures/recordings.svg",
        png="<results>/figures/recordings.png",
    log:
        "<logs>/summary_page.log",
    benchmark:
        "<benchmarks>/summary_page.tsv"
    resources:
        mem_mb=memory(500),
        runtime=minutes(10),
    params:
        code=source("summary_page.py", "noise", "lighthouse", "present"),
        caption=captions.SUMMARY,
        calibrations=columns("calibration", "setup", "group", "source", of=EVERY_CALIBRATION),
        cameras=groups(selection.subsets),
        compared=groups(pairs),
        subjects=subjects,
        papers=papers,
        tables=names_of_tables,
    message:
        "Summary"
    script:
        "../scripts/summary_page.py"


# One page for each recording, calibration, group and paper, in the folder of results.
rule detail_pages:
    input:
        results=results_of("recordings", "calibrations", "tables", "figures"),
        verdicts=collect("<results>/recordings/{row.recording}/verdict.json", row=EVERY_RECORDING),
        poses=collect("<results>/calibrations/{row.calibration}/pose.json", row=EVERY_CALIBRATION),
        changes=collect("<results>/tables/{group}_compare.json", group=groups(pairs)),
        claims=branch(together(OF_SKUROWSKI, OF_JANSEN), then=["<results>/tables/claims.csv"]),
    output:
        directory("<results>/details"),
    log:
        "<logs>/detail_pages.log",
    benchmark:
        "<benchmarks>/detail_pages.tsv"
    resources:
        mem_mb=memory(500),
        runtime=minutes(10),
    params:
        code=source("detail_pages.py", "noise", "lighthouse", "present"),
        recordings=columns("recording", "group", of=EVERY_RECORDING),
        calibrations=columns("calibration", "group", of=EVERY_CALIBRATION),
        groups=lambda wildcards: subjects(wildcards)["group"],
        papers=papers,
    message:
        "Pages of recordings, calibrations, groups and papers"
    script:
        "../scripts/detail_pages.py"


# After everything else, so that all run times are known.
rule provenance:
    input:
        pages=rules.detail_pages.output,  # whose inputs are all results
        tables=results_of("tables"),
        origins=together(
            collect(
                "<results>/recordings/{row.recording}/trajectories.parquet", row=EVERY_RECORDING
            ),
            collect("<results>/calibrations/{row.calibration}/pose.json", row=EVERY_CALIBRATION),
        ),
    output:
        page=report(
            "<results>/provenance.html",
            caption="../report/caption.rst",
            category="7 Provenance",
            labels={"result": "Provenance: versions, seeds, checksums, run times"},
        ),
        json="<results>/provenance.json",
    log:
        "<logs>/provenance.log",
    benchmark:
        "<benchmarks>/provenance.tsv"
    resources:
        mem_mb=memory(500),
        runtime=minutes(10),
    params:
        code=source("provenance.py", "present"),
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
        pages=["report_pages", "summary_page", "detail_pages", "provenance"],
        benchmarks=f"{config['results']}/benchmarks",
    message:
        "Provenance"
    script:
        "../scripts/provenance.py"


# Nothing is reported of calibrations alone.
PAGES = collect_outputs(
    rules.report_pages.output,
    rules.summary_page.output,
    rules.detail_pages.output,
    rules.provenance.output,
)
promise(pages=branch(EVERY_RECORDING, then=PAGES))
