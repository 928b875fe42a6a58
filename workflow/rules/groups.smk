# Recordings of a group side by side: tables of every group, figures of two recordings or more.

# The figures of the paper itself are in papers.smk
OTHERS = f"group != 'skurowski2019' and {ABOUT_NOISE}"
still = partial(accepted, query=NOISE_OF_GROUP)
CHECKS = checks(RECORDINGS, NOISE_OF_GROUP)
POINT = ("column_names", "accept_truncated")
DATED = still(selection.over_dates)
WITH_COVARIATE = still(selection.having("covariate"))
WITH_POINTS = still(selection.with_points)
WITH_PLACE = still(selection.with_place)
SUBSETS = still(selection.subsets)
BARS = accepted(query=f"{OF_GROUP} and {ABOUT_BAR}")

for_groups(
    "group_tables",
    of=groups(),
    input={
        "checks": checks(RECORDINGS, OF_GROUP),
        "verdicts": of_each("verdict.json", accepted()),
    },
    tables={"subsets": TABLE, "summary": TABLE, "mqc": ["json"]},
    params={"rows": columns(*SUBSET, "camera_ids", "comment", of=accepted())},
    message="tables of the group",
)
for_groups(
    "noise_tables",
    of=groups(query=ABOUT_NOISE),
    input={
        "checks": CHECKS,
        "gaussian": of_each("gaussian.csv", still()),
        "outliers": of_each("outliers.csv", still()),
        "allan": of_each("allan_masked.parquet", still()),
        "noise": of_each("noise.csv", still()),
    },
    tables=dict.fromkeys(("gaussian", "outliers", "allan", "noise"), TABLE),
    params={"rows": columns(*SUBSET, of=still())},
    message="tables of noise",
)

# What the recordings of a group are compared in.
compared = partial(for_groups, mem_mb=memory(1500), runtime=minutes(30))
compared(
    "families",
    of=groups(selection.several, OTHERS),
    input={
        "checks": CHECKS,
        "allan": of_each("allan_masked.parquet", still()),
        "noise": of_each("noise.csv", still()),
    },
    figures={
        "adev": "Allan deviation: all recordings, by series",
        "coefficients": "power-law noise: coefficients with intervals",
        "correlated": "correlated noise: amplitudes and correlation times",
    },
    params={"caption": captions.FAMILIES, "rows": columns(*SUBSET, of=still())},
    message="figures of the group",
)
# The paper's Figure 11 for any group with subsets of cameras
compared(
    "scaling",
    of=groups(selection.scaled, OTHERS),
    input={"checks": CHECKS, "gaussian": of_each("gaussian.csv", still())},
    figures={"scaling": "Spread: over the number of cameras"},
    params={"caption": captions.SCALING, "rows": columns(*SUBSET, of=still())},
    message="spread over the number of cameras",
)
compared(
    "compare",
    of=groups(pairs, ABOUT_NOISE),
    input={
        name: collect(f"<results>/recordings/{{pair[{k}]}}/allan_masked.parquet", pair=still(pairs))
        for k, name in enumerate(("new", "old"))
    },
    tables={"compare": (*TABLE, "json")},
    figures={"compare": "changes: ratios of Allan deviations"},
    params={"caption": captions.COMPARE, "pairs": still(pairs), "compare": config["compare"]},
    message="comparison with the reference",
)
compared(
    "trend",
    of=groups(selection.over_dates, ABOUT_NOISE),
    input={"allan": of_each("allan_masked.parquet", DATED)},
    tables={"trend": TABLE},
    figures={"trend": "trend: Allan deviations over dates"},
    params={
        "caption": captions.TREND,
        "series_over_dates": still(selection.series_over_dates),
        "dates": column("date", of=DATED),
        "compare": config["compare"],
    },
    message="change over dates",
)
compared(
    "coherence",
    of=groups(selection.having("covariate"), ABOUT_NOISE),
    input={
        "clean": of_each("clean.parquet", WITH_COVARIATE),
        "covariate": lambda wildcards: [
            located(row.covariate) for row in WITH_COVARIATE(wildcards)
        ],
    },
    tables={"coherence": TABLE},
    params={
        "contents": contents(selection.covariates, of=WITH_COVARIATE),
        "sources": column("source", of=WITH_COVARIATE),
        "compare": config["compare"],
    },
    message="noise against the covariate",
)
compared(
    "places",
    of=groups(selection.with_place, ABOUT_NOISE),
    input={
        "allan": of_each("allan_masked.parquet", WITH_PLACE),
        "clean": of_each("clean.parquet", WITH_PLACE),
    },
    tables={"places": TABLE},
    params={
        "rows": columns("recording", "place", "markers", of=WITH_PLACE),
        "sources": column("source", of=WITH_PLACE),
    },
    message="noise by place",
)
compared(
    "bars",
    of=groups(query=ABOUT_BAR),
    input={
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
    tables=dict.fromkeys(("bar", "statement"), (*TABLE, "json")),
    figures={"bar": "bar: errors of a length that moves, all passes"},
    more={
        f"statement_{kind}": f"<results>/figures/{{group}}_statement.{kind}"
        for kind in ("pdf", "png")
    },
    params={
        "captions": [captions.BAR, captions.BAR_TABLE, captions.STATEMENT],
        "settings": settings("bar", "place"),
    },
    message="all passes of a bar",
)
compared(
    "points",
    of=groups(selection.with_points, ABOUT_NOISE),
    input={
        "checks": CHECKS,
        "clean": of_each("clean.parquet", WITH_POINTS),
        "files": lambda wildcards: [
            located(path) for row in WITH_POINTS(wildcards) for path in row.paths
        ],
        "reference": lambda wildcards: sorted(
            {located(row.reference) for row in WITH_POINTS(wildcards)}
        ),
    },
    tables={"points": (*TABLE, "json")},
    figures={"points": "reference points: what each is off by"},
    params={
        "caption": captions.POINTS,
        "rows": columns("recording", "point", "source", "paths", *POINT, of=WITH_POINTS),
        "contents": contents(selection.references_of, of=WITH_POINTS),
    },
    message="reference points",
)
compared(
    "cameras",
    of=groups(selection.subsets, ABOUT_NOISE),
    input={
        "raw": of_each("trajectories.parquet", SUBSETS),
        "covariance": of_each("covariance.csv", SUBSETS),
        "noise": of_each("noise.csv", SUBSETS),
    },
    tables={"cameras": (*TABLE, "json"), "camera_law": TABLE},
    figures={"cameras": "cameras: noise with each camera added"},
    params={
        "caption": captions.CAMERAS,
        "takes": still(selection.takes),
        "rows": columns("recording", "camera_type", "camera_ids", of=SUBSETS),
        "cameras": config["cameras"],
        "mask_sigma": config["noise"]["mask_sigma"],
        "half_window_s": config["hampel"]["half_window_s"],
    },
    message="noise by number of cameras",
)

# A facility over its takes.
CHART = "<results>/monitors/{monitor}/chart.png"
MONITOR = job(
    "monitor",
    of="monitor",
    input={"takes": of_each("monitor_take.json", takes_of)},
    output={
        "chart": listed(CHART, "4 Groups", "monitor {monitor}: its takes over time"),
        "csv": "<results>/monitors/{monitor}/monitor.csv",
        "json": "<results>/monitors/{monitor}/monitor.json",
    },
    params={
        "rows": lambda wildcards: [vars(take) for take in MONITORS[wildcards.monitor]],
        "takes": lambda wildcards: [row.name for row in takes_of(wildcards)],
        "settings": settings("monitor"),
    },
    message="chart of its takes",
)
promise(figures=collect(MONITOR, monitor=list(MONITORS)))
