# Skurowski & Pawlyta 2019: tables and figures that stand for one of the paper's own.

SKUROWSKI_FIGURES = {
    1: ("skurowski_theory", "Gaussian model"),
    2: ("skurowski_theory", "standard error"),
    3: ("skurowski_theory", "slopes of an Allan deviation"),
    6: ("skurowski_noise", "weighted and ordinary least squares"),
    9: ("skurowski_gaussian", "where the markers were seen"),
    10: ("skurowski_gaussian", "the distance by sets of cameras"),
    11: ("skurowski_gaussian", "spread over the number of cameras"),
    14: ("skurowski_noise", "colour noise, logarithmic"),
    15: ("skurowski_noise", "colour noise, linear"),
    16: ("skurowski_noise", "correlated noise"),
    17: ("skurowski_noise", "periodic disturbance"),
}


# Nothing of this depends on a recording.
rule skurowski_theory:
    output:
        multiext(
            "<results>/tables/",
            *(
                f"{name}.{kind}"
                for name in ("skurowski_table1", "skurowski_table2", "left_out")
                for kind in ("csv", "md")
            ),
        ),
        [of_figure(n) for n in (1, 2, 3)],
        [f"<results>/figures/skurowski_fig{n:02d}.png" for n in (1, 2, 3)],
    log:
        "<logs>/skurowski_theory.log",
    benchmark:
        "<benchmarks>/skurowski_theory.tsv"
    threads: 1
    params:
        code=digest("skurowski_theory.py"),
    message:
        "Tables 1 and 2 and Figures 1-3 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_theory.py"


rule skurowski_tables:
    input:
        checks=checks("skurowski2019"),
        gaussian=of_paper("gaussian.csv"),
    output:
        multiext(
            "<results>/tables/skurowski_table",
            "3.csv",
            "3.md",
            "4.csv",
            "4.md",
        ),
    log:
        "<logs>/skurowski_tables.log",
    benchmark:
        "<benchmarks>/skurowski_tables.tsv"
    threads: 1
    params:
        code=digest("skurowski_tables.py"),
        rows=lambda wildcards: [row(name) for name in accepted("skurowski2019")],
        twins=lambda wildcards: twins_of_paper(),
        hampel=config["hampel"],
    message:
        "Tables 3 and 4 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_tables.py"


rule skurowski_gaussian_figures:
    input:
        checks=checks("skurowski2019"),
        gaussian=of_paper("gaussian.csv"),
        clean=lambda wildcards: [
            f"<results>/recordings/{name}/clean.parquet" for name in full_sets_of_paper()
        ],
    output:
        [of_figure(n) for n in (9, 10, 11)],
        [f"<results>/figures/skurowski_fig{n:02d}.png" for n in (9, 10, 11)],
    log:
        "<logs>/skurowski_gaussian_figures.log",
    benchmark:
        "<benchmarks>/skurowski_gaussian_figures.tsv"
    threads: 1
    resources:
        mem_mb=2000,
    params:
        code=digest("skurowski_gaussian_figures.py"),
        rows=lambda wildcards: [row(name) for name in accepted("skurowski2019")],
        twins=lambda wildcards: twins_of_paper(),
    message:
        "Figures 9-11 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_gaussian_figures.py"


rule skurowski_noise:
    input:
        checks=checks("skurowski2019"),
        noise=of_paper("noise.csv"),
        expected=of_paper_twins("expected.csv"),
    output:
        multiext(
            "<results>/tables/skurowski_",
            "tableA1.csv",
            "tableA1.md",
            "tableA2.csv",
            "tableA2.md",
            "tableA3.csv",
            "tableA3.md",
            "support.csv",
            "support.md",
            "white_levels.csv",
            "white_levels.md",
        ),
    log:
        "<logs>/skurowski_noise.log",
    benchmark:
        "<benchmarks>/skurowski_noise.tsv"
    threads: 1
    params:
        code=digest("skurowski_noise.py"),
        rows=lambda wildcards: [row(name) for name in accepted("skurowski2019")],
    message:
        "Tables A1-A3 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_noise.py"


rule skurowski_noise_figures:
    input:
        checks=checks("skurowski2019"),
        noise=of_paper("noise.csv"),
        expected=of_paper_twins("expected.csv"),
        allan=of_paper("allan.parquet"),
        psd=of_paper("psd.parquet"),
    output:
        [of_figure(n) for n in (6, 14, 15, 16, 17)],
        [f"<results>/figures/skurowski_fig{n:02d}.png" for n in (6, 14, 15, 16, 17)],
    log:
        "<logs>/skurowski_noise_figures.log",
    benchmark:
        "<benchmarks>/skurowski_noise_figures.tsv"
    threads: 1
    resources:
        mem_mb=1500,
    params:
        code=digest("skurowski_noise_figures.py"),
        rows=lambda wildcards: [row(name) for name in accepted("skurowski2019")],
        noise=config["noise"],
        annealing=config["annealing"],
        allan=config["allan"],
        hampel=config["hampel"],
        seed=config["seed"],
    message:
        "Figures 6 and 14-17 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_noise_figures.py"


# The paper's Figure 11 for any group with subsets of cameras.
rule scaling:
    input:
        checks=lambda wildcards: checks(wildcards.group),
        gaussian=of_accepted("<results>/recordings/{recording}/gaussian.csv"),
    output:
        report(
            "<results>/figures/{group}_scaling.svg",
            caption="../report/scaling.rst",
            category="Groups",
            subcategory="{group}",
            labels={"item": "Spread", "shows": "over the number of cameras"},
        ),
        "<results>/figures/{group}_scaling.png",
    log:
        "<logs>/scaling/{group}.log",
    benchmark:
        "<benchmarks>/scaling/{group}.tsv"
    threads: 1
    params:
        code=digest("scaling.py"),
        rows=rows_of_accepted,
    message:
        "{wildcards.group}: spread over the number of cameras"
    script:
        "../scripts/scaling.py"
