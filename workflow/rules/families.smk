# Recordings side by side: figures of S, and of every group of two recordings or more.


rule families:
    input:
        checks=lambda wildcards: checks(wildcards.group),
        allan=of_accepted("<results>/recordings/{recording}/allan.parquet"),
        noise=of_accepted("<results>/recordings/{recording}/noise.csv"),
    output:
        report(
            "<results>/figures/{group}_adev.svg",
            caption="../report/families.rst",
            category="Groups",
            subcategory="{group}",
            labels={"item": "Allan deviation", "shows": "all recordings, by series"},
        ),
        "<results>/figures/{group}_adev.png",
        report(
            "<results>/figures/{group}_coefficients.svg",
            caption="../report/families.rst",
            category="Groups",
            subcategory="{group}",
            labels={"item": "power-law noise", "shows": "coefficients with intervals"},
        ),
        "<results>/figures/{group}_coefficients.png",
        report(
            "<results>/figures/{group}_correlated.svg",
            caption="../report/families.rst",
            category="Groups",
            subcategory="{group}",
            labels={"item": "correlated noise", "shows": "amplitudes and correlation times"},
        ),
        "<results>/figures/{group}_correlated.png",
    log:
        "<logs>/families/{group}.log",
    benchmark:
        "<benchmarks>/families/{group}.tsv"
    threads: 1
    params:
        code=digest("families.py"),
        rows=rows_of_accepted,
    message:
        "{wildcards.group}: recordings side by side"
    script:
        "../scripts/families.py"


rule skurowski_crump:
    input:
        raw=of_shock("trajectories.parquet"),
        clean=of_shock("clean.parquet"),
        allan=lambda wildcards: [allan_of(name) for name in [*shocked(), *unshocked()]],
    output:
        report(
            "<results>/figures/skurowski_fig07.svg",
            caption="../report/skurowski_families.rst",
            category="Skurowski & Pawlyta 2019",
            labels={"item": "Figure 7", "shows": "a seismic crump"},
        ),
        "<results>/figures/skurowski_fig07.png",
    log:
        "<logs>/skurowski_crump.log",
    benchmark:
        "<benchmarks>/skurowski_crump.tsv"
    threads: 1
    resources:
        mem_mb=2500,
    params:
        code=digest("skurowski_crump.py"),
        rows=lambda wildcards: [row(name) for name in [*shocked(), *unshocked()]],
    message:
        "Figure 7 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_crump.py"


rule skurowski_failing:
    input:
        allan=lambda wildcards: [allan_of(name) for name in with_and_without_failing()],
    output:
        report(
            "<results>/figures/skurowski_fig08.svg",
            caption="../report/skurowski_families.rst",
            category="Skurowski & Pawlyta 2019",
            labels={"item": "Figure 8", "shows": "a failing camera"},
        ),
        "<results>/figures/skurowski_fig08.png",
    log:
        "<logs>/skurowski_failing.log",
    benchmark:
        "<benchmarks>/skurowski_failing.tsv"
    threads: 1
    params:
        code=digest("skurowski_families.py"),
        rows=lambda wildcards: [row(name) for name in with_and_without_failing()],
    message:
        "Figure 8 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_families.py"


rule skurowski_families:
    input:
        checks=checks("skurowski2019"),
        allan=of_paper("allan.parquet"),
    output:
        report(
            "<results>/figures/skurowski_fig12.svg",
            caption="../report/skurowski_families.rst",
            category="Skurowski & Pawlyta 2019",
            labels={"item": "Figure 12", "shows": "Allan deviation by number of cameras"},
        ),
        "<results>/figures/skurowski_fig12.png",
        report(
            "<results>/figures/skurowski_fig13.svg",
            caption="../report/skurowski_families.rst",
            category="Skurowski & Pawlyta 2019",
            labels={"item": "Figure 13", "shows": "Allan deviation by camera type"},
        ),
        "<results>/figures/skurowski_fig13.png",
    log:
        "<logs>/skurowski_families.log",
    benchmark:
        "<benchmarks>/skurowski_families.tsv"
    threads: 1
    params:
        code=digest("skurowski_families.py"),
        rows=lambda wildcards: [row(name) for name in accepted("skurowski2019")],
    message:
        "Figures 12 and 13 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_families.py"


rule skurowski_repaired:
    input:
        checks=checks("skurowski2019-repaired"),
        allan=lambda wildcards: [allan_of(name) for name in [*repaired(), *unrepaired()]],
    output:
        report(
            "<results>/figures/skurowski_figA1.svg",
            caption="../report/skurowski_families.rst",
            category="Skurowski & Pawlyta 2019",
            labels={"item": "Figure A1", "shows": "z1 after the repair"},
        ),
        "<results>/figures/skurowski_figA1.png",
    log:
        "<logs>/skurowski_repaired.log",
    benchmark:
        "<benchmarks>/skurowski_repaired.tsv"
    threads: 1
    params:
        code=digest("skurowski_families.py"),
        rows=lambda wildcards: [row(name) for name in repaired()],
        others=lambda wildcards: [row(name) for name in unrepaired()],
    message:
        "Figure A1 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_families.py"
