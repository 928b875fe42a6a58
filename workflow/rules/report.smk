# Parts of the report besides figures: tables as pages, the summary, provenance.


SUBSET_GROUPS = groups(selection.subsets, ABOUT_NOISE)
COMPARED_GROUPS = groups(pairs, ABOUT_NOISE)


# One page for each table, recording, calibration, group and paper, and the summary.
PAGES = job(
    "pages",
    input={
        "results": results_of("recordings", "calibrations", "tables", "figures"),
        "tables": results_of("tables"),
        "checks": checks(RECORDINGS) + checks(CALIBRATIONS),
        "verdicts": of_each("verdict.json", EVERY_RECORDING),
        "poses": of_each("pose.json", EVERY_CALIBRATION, CALIBRATIONS),
        "cameras": collect("<results>/tables/{group}_cameras.json", group=SUBSET_GROUPS),
        "changes": collect("<results>/tables/{group}_compare.json", group=COMPARED_GROUPS),
        "monitors": collect("<results>/monitors/{name}/monitor.json", name=MONITORS),
        "claims": branch(BOTH, then=["<results>/tables/claims.csv"]),
    },
    output={
        # With the category and labels of the table's title
        "tables": report(
            directory("<results>/pages"),
            patterns=["{table}.html"],
            caption="../report/caption.rst",
            category=entry("category"),
            subcategory=entry("subcategory"),
            labels=entry("labels"),
        ),
        "summary": report(
            "<results>/summary.html",
            caption="../report/summary.rst",
            category="1 Summary",
            labels={"result": "Verdicts: every recording and calibration"},
        ),
        "front": "<results>/report_front.html",
        "svg": "<results>/figures/recordings.svg",
        "png": "<results>/figures/recordings.png",
        "details": directory("<results>/details"),
    },
    params={
        "caption": captions.TABLE,
        "summary": captions.SUMMARY,
        "recordings": columns("recording", "group", of=EVERY_RECORDING),
        "calibrations": columns("calibration", "setup", "group", "source", of=EVERY_CALIBRATION),
        "cameras": SUBSET_GROUPS,
        "compared": COMPARED_GROUPS,
        "subjects": subjects,
        "papers": papers,
    },
    message="Pages of tables, recordings, calibrations, groups and papers, and the summary",
)


# After everything else, so that all run times are known.
PROVENANCE = job(
    "provenance",
    input={
        "pages": PAGES,  # whose inputs are all results
        "tables": results_of("tables"),
        "origins": together(
            lambda wildcards: [
                f"{config['results']}/recordings/{row.name}/"
                f"{'bar' if row.bar else 'trajectories'}.parquet"
                for row in EVERY_RECORDING(wildcards)
            ],
            of_each("pose.json", EVERY_CALIBRATION, CALIBRATIONS),
        ),
    },
    output={
        "page": listed(
            "<results>/provenance.html",
            "7 Provenance",
            "Provenance: versions, seeds, checksums, run times",
        ),
        "json": "<results>/provenance.json",
    },
    params={
        "caption": captions.PROVENANCE,
        "configuration": reporting.plain_configuration(config),
        "inputs": together(
            accepted(partial(reporting.inputs, twins=TWINS), EVERY),
            accepted_calibrations(partial(reporting.inputs, twins=CALIBRATION_TWINS), EVERY),
        ),
        "names": [
            *RECORDINGS.rows,
            *CALIBRATIONS.rows,
            *RECORDINGS.groups,
            *CALIBRATIONS.groups,
            *CASES,
        ],
        "pages": ["pages", "provenance"],
        "benchmarks": f"{config['results']}/benchmarks",
    },
    message="Provenance",
)


# Nothing is reported of calibrations alone.
promise(pages=branch(EVERY_RECORDING, then=PAGES + PROVENANCE))
