# Recordings of a group side by side: tables of every group, figures of two recordings or more.

# The figures of the paper itself are in skurowski.smk
OTHERS = f"group != 'skurowski2019' and {ABOUT_NOISE}"
still = partial(accepted, query=NOISE_OF_GROUP)
POINT = ("column_names", "accept_truncated")
DATED = still(selection.over_dates)
WITH_COVARIATE = still(selection.having("covariate"))
WITH_POINTS = still(selection.with_points)
WITH_PLACE = still(selection.with_place)
SUBSETS = still(selection.subsets)
BARS = accepted(query=f"{OF_GROUP} and {ABOUT_BAR}")

# What is made of the recordings of a group: for which groups, what is read, the files that are
# written, with the labels of figures in the report, and what the script is told.
OF_GROUPS = {
    "group_tables": {
        "of": groups(),
        "input": {
            "checks": checks(RECORDINGS, OF_GROUP),
            "verdicts": of_each("verdict.json", accepted()),
        },
        "output": {"tables": tables_by_name("subsets", "summary") | {"multiqc": "mqc.json"}},
        "params": {"rows": columns(*SUBSET, "camera_ids", "comment", of=accepted())},
        "message": "tables of the group",
    },
    "noise_tables": {
        "of": groups(query=ABOUT_NOISE),
        "input": {
            "checks": checks(RECORDINGS, NOISE_OF_GROUP),
            "gaussian": of_each("gaussian.csv", still()),
            "outliers": of_each("outliers.csv", still()),
            "allan": of_each("allan_masked.parquet", still()),
            "noise": of_each("noise.csv", still()),
        },
        "output": {"tables": tables_by_name("gaussian", "outliers", "allan", "noise")},
        "params": {"rows": columns(*SUBSET, of=still())},
        "message": "tables of noise",
    },
    "families": {
        "of": groups(lambda rows: len(rows) > 1, OTHERS),
        "input": {
            "checks": checks(RECORDINGS, NOISE_OF_GROUP),
            "allan": of_each("allan_masked.parquet", still()),
            "noise": of_each("noise.csv", still()),
        },
        "output": {
            "figures": {
                "adev": "Allan deviation: all recordings, by series",
                "coefficients": "power-law noise: coefficients with intervals",
                "correlated": "correlated noise: amplitudes and correlation times",
            }
        },
        "params": {"caption": captions.FAMILIES, "rows": columns(*SUBSET, of=still())},
        "message": "figures of the group",
    },
    # The paper's Figure 11 for any group with subsets of cameras
    "scaling": {
        "of": groups(selection.scaled, OTHERS),
        "input": {
            "checks": checks(RECORDINGS, NOISE_OF_GROUP),
            "gaussian": of_each("gaussian.csv", still()),
        },
        "output": {"figures": {"scaling": "Spread: over the number of cameras"}},
        "params": {"caption": captions.SCALING, "rows": columns(*SUBSET, of=still())},
        "message": "spread over the number of cameras",
    },
    "compare": {
        "of": groups(pairs, ABOUT_NOISE),
        "input": {
            f"{name}{of}": collect(f"<results>/recordings/{{pair[{k}]}}/{file}", pair=still(pairs))
            for k, name in enumerate(("new", "old"))
            for of, file in (("", "allan_masked.parquet"), ("_diagnosis", "diagnosis.json"))
        },
        "output": {
            "tables": {"csv": "compare.csv", "md": "compare.md", "json": "compare.json"},
            "figures": {"compare": "changes: ratios of Allan deviations"},
        },
        "params": {
            "caption": captions.COMPARE,
            "pairs": still(pairs),
            "compare": config["compare"],
        },
        "message": "comparison with the reference",
    },
    "trend": {
        "of": groups(selection.over_dates, ABOUT_NOISE),
        "input": {"allan": of_each("allan_masked.parquet", DATED)},
        "output": {
            "tables": {"csv": "trend.csv", "md": "trend.md"},
            "figures": {"trend": "trend: Allan deviations over dates"},
        },
        "params": {
            "caption": captions.TREND,
            "series_over_dates": still(selection.series_over_dates),
            "dates": column("date", of=DATED),
            "compare": config["compare"],
        },
        "message": "change over dates",
    },
    "coherence": {
        "of": groups(selection.having("covariate"), ABOUT_NOISE),
        "input": {
            "clean": of_each("clean.parquet", WITH_COVARIATE),
            "covariate": lambda wildcards: [
                located(row.covariate) for row in WITH_COVARIATE(wildcards)
            ],
        },
        "output": {"tables": {"csv": "coherence.csv", "md": "coherence.md"}},
        "params": {
            "contents": contents(selection.covariates, of=WITH_COVARIATE),
            "sources": column("source", of=WITH_COVARIATE),
            "compare": config["compare"],
        },
        "message": "noise against the covariate",
    },
    "places": {
        "of": groups(selection.with_place, ABOUT_NOISE),
        "input": {
            "allan": of_each("allan_masked.parquet", WITH_PLACE),
            "clean": of_each("clean.parquet", WITH_PLACE),
        },
        "output": {"tables": {"csv": "places.csv", "md": "places.md"}},
        "params": {
            "rows": columns("recording", "place", "markers", of=WITH_PLACE),
            "sources": column("source", of=WITH_PLACE),
        },
        "message": "noise by place",
    },
    "bars": {
        "of": groups(query=ABOUT_BAR),
        "input": {
            "checks": checks(RECORDINGS, OF_GROUP),
            "takes": of_each("bar.parquet", BARS),
            "verdicts": of_each("verdict.json", still()),
            # What else is known of the uncertainty of a length
            "monitors": lambda wildcards: [
                f"{config['results']}/monitors/{name}/monitor.json"
                for name in dict.fromkeys(row.monitor for row in accepted()(wildcards))
                if name
            ],
            "points": lambda wildcards: [
                f"{config['results']}/tables/{wildcards.group}_points.json"
                for _ in WITH_POINTS(wildcards)[:1]
            ],
        },
        "output": {
            "tables": {
                "csv": "bar.csv",
                "md": "bar.md",
                "json": "bar.json",
                "statement_csv": "statement.csv",
                "statement_md": "statement.md",
                "statement_json": "statement.json",
            },
            "figures": {"bar": "bar: errors of a length that moves, all passes"},
            "pages": ["statement"],
        },
        "params": {
            "captions": [captions.BAR, captions.BAR_TABLE, captions.STATEMENT],
            "settings": settings("bar", "place"),
        },
        "message": "all passes of a bar",
    },
    "points": {
        "of": groups(selection.with_points, ABOUT_NOISE),
        "input": {
            "checks": checks(RECORDINGS, NOISE_OF_GROUP),
            "clean": of_each("clean.parquet", WITH_POINTS),
            "files": lambda wildcards: [
                located(path) for row in WITH_POINTS(wildcards) for path in row.paths
            ],
            "reference": lambda wildcards: sorted(
                {located(row.reference) for row in WITH_POINTS(wildcards)}
            ),
        },
        "output": {
            "tables": {"csv": "points.csv", "md": "points.md", "json": "points.json"},
            "figures": {"points": "reference points: what each is off by"},
        },
        "params": {
            "caption": captions.POINTS,
            "rows": columns("recording", "point", "source", "paths", *POINT, of=WITH_POINTS),
            "contents": contents(selection.references_of, of=WITH_POINTS),
        },
        "message": "reference points",
    },
    "cameras": {
        "of": groups(selection.subsets, ABOUT_NOISE),
        "input": {
            "raw": of_each("trajectories.parquet", SUBSETS),
            "covariance": of_each("covariance.csv", SUBSETS),
            "noise": of_each("noise.csv", SUBSETS),
        },
        "output": {
            "tables": {
                "csv": "cameras.csv",
                "md": "cameras.md",
                "law": "camera_law.csv",
                "law_md": "camera_law.md",
                "json": "cameras.json",
            },
            "figures": {"cameras": "cameras: noise with each camera added"},
        },
        "params": {
            "caption": captions.CAMERAS,
            "takes": still(selection.takes),
            "rows": columns("recording", "camera_type", "camera_ids", of=SUBSETS),
            "cameras": config["cameras"],
            "mask_sigma": config["noise"]["mask_sigma"],
            "half_window_s": config["hampel"]["half_window_s"],
        },
        "message": "noise by number of cameras",
    },
}

for NAME, OF in OF_GROUPS.items():

    rule:
        name:
            NAME
        input:
            **OF["input"],
        output:
            **outputs_of_group(**OF["output"]),
        log:
            f"<logs>/{NAME}/{{group}}.log",
        resources:
            **cost(1500, 30),
        params:
            **OF["params"],
            code=source(f"{NAME}.py"),
            script=NAME,
        message:
            f"{{wildcards.group}}: {OF['message']}"
        script:
            "../scripts/{params.script}.py"  # by name: NAME is the last one when a job runs


# A facility over its takes.
rule monitor:
    input:
        takes=of_each("monitor_take.json", takes_of),
    output:
        listed(
            "<results>/monitors/{monitor}/chart.png",
            "4 Groups",
            "monitor {monitor}: its takes over time",
        ),
        "<results>/monitors/{monitor}/monitor.csv",
        json="<results>/monitors/{monitor}/monitor.json",
    log:
        "<logs>/monitor/{monitor}.log",
    resources:
        **cost(500, 10),
    params:
        code=source("monitor.py"),
        rows=lambda wildcards: [vars(take) for take in MONITORS[wildcards.monitor]],
        takes=lambda wildcards: [row.name for row in takes_of(wildcards)],
        settings=settings("monitor"),
    message:
        "{wildcards.monitor}: chart of its takes"
    script:
        "../scripts/monitor.py"


promise(
    figures=collect_outputs(rules.monitor.output, monitor=list(MONITORS)),
    tables=together(
        *(
            collect_outputs(getattr(rules, name).output, group=of["of"])
            for name, of in OF_GROUPS.items()
        )
    ),
)
