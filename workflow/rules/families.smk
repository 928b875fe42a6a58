# Recordings side by side, of every group of two recordings or more.


rule families:
    input:
        checks=lambda wildcards: checks(wildcards.group),
        allan=of_accepted("<results>/recordings/{recording}/allan_masked.parquet"),
        noise=of_accepted("<results>/recordings/{recording}/noise.csv"),
    output:
        report(
            "<results>/figures/{group}_adev.svg",
            caption="../report/families.rst",
            category="4 Groups",
            subcategory="{group}",
            labels={"result": "Allan deviation: all recordings, by series"},
        ),
        "<results>/figures/{group}_adev.png",
        report(
            "<results>/figures/{group}_coefficients.svg",
            caption="../report/families.rst",
            category="4 Groups",
            subcategory="{group}",
            labels={"result": "power-law noise: coefficients with intervals"},
        ),
        "<results>/figures/{group}_coefficients.png",
        report(
            "<results>/figures/{group}_correlated.svg",
            caption="../report/families.rst",
            category="4 Groups",
            subcategory="{group}",
            labels={"result": "correlated noise: amplitudes and correlation times"},
        ),
        "<results>/figures/{group}_correlated.png",
    log:
        "<logs>/families/{group}.log",
    benchmark:
        "<benchmarks>/families/{group}.tsv"
    threads: 1
    params:
        code=source("families.py", "noise", "present"),
        rows=lambda wildcards: columns_of(accepted_rows(wildcards.group), *SUBSET),
    message:
        "{wildcards.group}: recordings side by side"
    script:
        "../scripts/families.py"


# The paper's Figure 11 for any group with subsets of cameras.
rule scaling:
    input:
        checks=lambda wildcards: checks(wildcards.group),
        gaussian=of_accepted("<results>/recordings/{recording}/gaussian.csv"),
    output:
        report(
            "<results>/figures/{group}_scaling.svg",
            caption="../report/scaling.rst",
            category="4 Groups",
            subcategory="{group}",
            labels={"result": "Spread: over the number of cameras"},
        ),
        "<results>/figures/{group}_scaling.png",
    log:
        "<logs>/scaling/{group}.log",
    benchmark:
        "<benchmarks>/scaling/{group}.tsv"
    threads: 1
    params:
        code=source("scaling.py", "noise", "present"),
        rows=lambda wildcards: columns_of(accepted_rows(wildcards.group), *SUBSET),
    message:
        "{wildcards.group}: spread over the number of cameras"
    script:
        "../scripts/scaling.py"
