# Has the system changed? Recordings against their reference, over dates, and beside a covariate.


rule compare:
    input:
        new=lambda wildcards: [allan_of(a) for a, _ in comparisons(wildcards.group)],
        old=lambda wildcards: [allan_of(b) for _, b in comparisons(wildcards.group)],
    output:
        csv="<results>/tables/{group}_compare.csv",
        md="<results>/tables/{group}_compare.md",
        json="<results>/tables/{group}_compare.json",
        svg=report(
            "<results>/figures/{group}_compare.svg",
            caption="../report/compare.rst",
            category="4 Groups",
            subcategory="{group}",
            labels={"result": "changes: ratios of Allan deviations"},
        ),
        png="<results>/figures/{group}_compare.png",
    log:
        "<logs>/compare/{group}.log",
    benchmark:
        "<benchmarks>/compare/{group}.tsv"
    threads: 1
    params:
        code=source("compare.py", "noise", "present"),
        pairs=lambda wildcards: comparisons(wildcards.group),
        sources=lambda wildcards: sources_of(sum(comparisons(wildcards.group), ())),
        compare=config["compare"],
    message:
        "{wildcards.group}: what has changed"
    script:
        "../scripts/compare.py"


rule trend:
    input:
        lambda wildcards: [allan_of(name) for name in sum(dated_series(wildcards.group), [])],
    output:
        csv="<results>/tables/{group}_trend.csv",
        md="<results>/tables/{group}_trend.md",
        svg=report(
            "<results>/figures/{group}_trend.svg",
            caption="../report/trend.rst",
            category="4 Groups",
            subcategory="{group}",
            labels={"result": "trend: Allan deviations over dates"},
        ),
        png="<results>/figures/{group}_trend.png",
    log:
        "<logs>/trend/{group}.log",
    benchmark:
        "<benchmarks>/trend/{group}.tsv"
    threads: 1
    params:
        code=source("trend.py", "noise", "present"),
        series_over_dates=lambda wildcards: dated_series(wildcards.group),
        dates=lambda wildcards: {
            name: row(name)["date"] for name in sum(dated_series(wildcards.group), [])
        },
        sources=lambda wildcards: sources_of(sum(dated_series(wildcards.group), [])),
        compare=config["compare"],
    message:
        "{wildcards.group}: change over dates"
    script:
        "../scripts/trend.py"


rule coherence:
    input:
        clean=lambda wildcards: [
            f"<results>/recordings/{name}/clean.parquet"
            for name in with_covariate(wildcards.group)
        ],
        covariate=lambda wildcards: [
            row(name)["covariate"] for name in with_covariate(wildcards.group)
        ],
    output:
        csv="<results>/tables/{group}_coherence.csv",
        md="<results>/tables/{group}_coherence.md",
    log:
        "<logs>/coherence/{group}.log",
    benchmark:
        "<benchmarks>/coherence/{group}.tsv"
    threads: 1
    resources:
        mem_mb=1000,
    params:
        code=source("coherence.py", "io", "noise", "present"),
        sources=lambda wildcards: sources_of(with_covariate(wildcards.group)),
        compare=config["compare"],
    message:
        "{wildcards.group}: what noise goes with"
    script:
        "../scripts/coherence.py"
