# Changes of a system: recordings against a reference, over dates, and against a covariate.

DATED = accepted(selection.over_dates)
WITH_COVARIATE = accepted(selection.with_covariate)


rule compare:
    input:
        new=collect("<results>/recordings/{pair[0]}/allan_masked.parquet", pair=accepted(pairs)),
        old=collect("<results>/recordings/{pair[1]}/allan_masked.parquet", pair=accepted(pairs)),
    output:
        csv="<results>/tables/{group}_compare.csv",
        md="<results>/tables/{group}_compare.md",
        json="<results>/tables/{group}_compare.json",
        svg=report(
            "<results>/figures/{group}_compare.svg",
            caption="../report/caption.rst",
            category="4 Groups",
            subcategory="{group}",
            labels={"result": "changes: ratios of Allan deviations"},
        ),
        png="<results>/figures/{group}_compare.png",
    log:
        "<logs>/compare/{group}.log",
    benchmark:
        "<benchmarks>/compare/{group}.tsv"
    resources:
        mem_mb=memory(500),
        runtime=minutes(10),
    params:
        code=source("compare.py", "noise", "present"),
        caption=captions.COMPARE,
        pairs=accepted(pairs),
        compare=config["compare"],
    message:
        "{wildcards.group}: comparison with the reference"
    script:
        "../scripts/compare.py"


rule trend:
    input:
        collect("<results>/recordings/{row.recording}/allan_masked.parquet", row=DATED),
    output:
        csv="<results>/tables/{group}_trend.csv",
        md="<results>/tables/{group}_trend.md",
        svg=report(
            "<results>/figures/{group}_trend.svg",
            caption="../report/caption.rst",
            category="4 Groups",
            subcategory="{group}",
            labels={"result": "trend: Allan deviations over dates"},
        ),
        png="<results>/figures/{group}_trend.png",
    log:
        "<logs>/trend/{group}.log",
    benchmark:
        "<benchmarks>/trend/{group}.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(10),
    params:
        code=source("trend.py", "noise", "present"),
        caption=captions.TREND,
        series_over_dates=accepted(selection.series_over_dates),
        dates=column("date", of=DATED),
        compare=config["compare"],
    message:
        "{wildcards.group}: change over dates"
    script:
        "../scripts/trend.py"


rule coherence:
    input:
        clean=collect("<results>/recordings/{row.recording}/clean.parquet", row=WITH_COVARIATE),
        covariate=lambda wildcards: [located(row.covariate) for row in WITH_COVARIATE(wildcards)],
    output:
        csv="<results>/tables/{group}_coherence.csv",
        md="<results>/tables/{group}_coherence.md",
    log:
        "<logs>/coherence/{group}.log",
    benchmark:
        "<benchmarks>/coherence/{group}.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(10),
    params:
        code=source("coherence.py", "io", "noise", "present"),
        contents=contents(selection.covariates, of=WITH_COVARIATE),
        sources=column("source", of=WITH_COVARIATE),
        compare=config["compare"],
    message:
        "{wildcards.group}: noise against the covariate"
    script:
        "../scripts/coherence.py"


rule compare_results:
    input:
        tables=together(
            collect_outputs(rules.compare.output, group=groups(pairs)),
            collect_outputs(rules.trend.output, group=groups(selection.over_dates)),
            collect_outputs(rules.coherence.output, group=groups(selection.with_covariate)),
        ),
