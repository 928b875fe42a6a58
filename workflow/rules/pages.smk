# What the report shows besides figures: tables as pages, the summary, provenance.


# A page a table, with the category and labels that its title says.
rule report_pages:
    input:
        lambda wildcards: tables_as_text(),
        lambda wildcards: [f"{path[:-3]}.csv" for path in tables_as_text()],
    output:
        report(
            directory("<results>/pages"),
            patterns=["{table}.html"],
            caption="../report/table.rst",
            category=lambda wildcards: entry_of(wildcards)["category"],
            subcategory=lambda wildcards: entry_of(wildcards)["subcategory"],
            labels=lambda wildcards: entry_of(wildcards)["labels"],
        ),
    log:
        "<logs>/report_pages.log",
    benchmark:
        "<benchmarks>/report_pages.tsv"
    threads: 1
    params:
        code=source("report_pages.py", "present"),
    message:
        "Tables as pages"
    script:
        "../scripts/report_pages.py"


rule summary_page:
    input:
        checks=checks() + calibration_checks(),
        verdicts=lambda wildcards: verdict_files(),
        poses=lambda wildcards: [
            f"<results>/calibrations/{name}/pose.json" for name in accepted_calibrations()
        ],
        cameras=lambda wildcards: [
            f"<results>/tables/{group}_cameras.json" for group in groups_with_cameras()
        ],
    output:
        page=report(
            "<results>/summary.html",
            caption="../report/summary.rst",
            category="1 Summary",
            labels={"result": "Verdicts: every recording and calibration"},
        ),
        front="<results>/report_front.html",
    log:
        "<logs>/summary_page.log",
    benchmark:
        "<benchmarks>/summary_page.tsv"
    threads: 1
    params:
        code=source("summary_page.py", "noise", "lighthouse", "present"),
        calibrations=lambda wildcards: columns_of(
            map(calibration_row, accepted_calibrations()),
            *("calibration", "setup", "group", "source"),
        ),
        cameras=lambda wildcards: groups_with_cameras(),
        links=lambda wildcards: links_of_report(),
    message:
        "Summary"
    script:
        "../scripts/summary_page.py"


# After everything else, so that all run times are known.
rule provenance:
    input:
        results=lambda wildcards: results_without_report(),
        tables=lambda wildcards: [f"{path[:-3]}.csv" for path in tables_as_text()],
        origins=lambda wildcards: origins(),
    output:
        page=report(
            "<results>/provenance.html",
            caption="../report/provenance.rst",
            category="7 Provenance",
            labels={"result": "Provenance: versions, seeds, checksums, run times"},
        ),
        json="<results>/provenance.json",
    log:
        "<logs>/provenance.log",
    benchmark:
        "<benchmarks>/provenance.tsv"
    threads: 1
    params:
        code=source("provenance.py", "noise", "present"),
        configuration=lambda wildcards: configuration_of_report(),
        inputs=lambda wildcards: inputs_of_report(),
        names=[*RECORDINGS, *CALIBRATIONS, *groups(), *calibration_groups()],
        pages=["report_pages", "summary_page", "provenance"],
        benchmarks=f"{config['results']}/benchmarks",
    message:
        "Provenance"
    script:
        "../scripts/provenance.py"
