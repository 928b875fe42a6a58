# Skurowski & Pawlyta 2019: tables and figures that stand for one of the paper's own.

SKUROWSKI_FIGURES = {
    1: ("skurowski_theory", "Gaussian model"),
    2: ("skurowski_theory", "standard error"),
    3: ("skurowski_theory", "slopes of an Allan deviation"),
    6: ("skurowski_noise", "weighted and ordinary least squares"),
    7: ("skurowski_families", "a seismic crump"),
    8: ("skurowski_families", "a failing camera"),
    9: ("skurowski_gaussian", "where the markers were seen"),
    10: ("skurowski_gaussian", "the distance by sets of cameras"),
    11: ("skurowski_gaussian", "spread over the number of cameras"),
    12: ("skurowski_families", "Allan deviation by number of cameras"),
    13: ("skurowski_families", "Allan deviation by camera type"),
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
        code=source("skurowski_theory.py", "noise", "present"),
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
        code=source("skurowski_tables.py", "noise", "present"),
        rows=lambda wildcards: columns_of(accepted_rows("skurowski2019"), *SUBSET, "camera_ids"),
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
        code=source("skurowski_gaussian_figures.py", "noise", "present"),
        rows=lambda wildcards: columns_of(accepted_rows("skurowski2019"), *SUBSET),
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
        code=source("skurowski_noise.py", "noise", "present"),
        rows=lambda wildcards: columns_of(accepted_rows("skurowski2019"), *SUBSET),
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
        code=source("skurowski_noise_figures.py", "noise", "present"),
        rows=lambda wildcards: columns_of(accepted_rows("skurowski2019"), *SUBSET),
        noise=config["noise"],
        annealing=config["annealing"],
        allan=config["allan"],
        hampel=config["hampel"],
        seed=config["seed"],
    message:
        "Figures 6 and 14-17 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_noise_figures.py"


rule skurowski_crump:
    input:
        raw=of_shock("trajectories.parquet"),
        clean=of_shock("clean.parquet"),
        allan=lambda wildcards: [cleaned_allan_of(name) for name in [*shocked(), *unshocked()]],
    output:
        of_figure(7),
        "<results>/figures/skurowski_fig07.png",
    log:
        "<logs>/skurowski_crump.log",
    benchmark:
        "<benchmarks>/skurowski_crump.tsv"
    threads: 1
    resources:
        mem_mb=2500,
    params:
        code=source("skurowski_crump.py", "coordinates.py", "noise", "present"),
        rows=lambda wildcards: columns_of(map(row, [*shocked(), *unshocked()]), "recording", "twin"),
        crumps=lambda wildcards: twin_values(shocked(), "crump"),
    message:
        "Figure 7 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_crump.py"


rule skurowski_failing:
    input:
        allan=lambda wildcards: [cleaned_allan_of(name) for name in with_and_without_failing()],
    output:
        of_figure(8),
        "<results>/figures/skurowski_fig08.png",
    log:
        "<logs>/skurowski_failing.log",
    benchmark:
        "<benchmarks>/skurowski_failing.tsv"
    threads: 1
    params:
        code=source("skurowski_families.py", "noise", "present"),
        rows=lambda wildcards: columns_of(map(row, with_and_without_failing()), *SUBSET),
    message:
        "Figure 8 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_families.py"


rule skurowski_families:
    input:
        checks=checks("skurowski2019"),
        allan=of_paper("allan.parquet"),
    output:
        of_figure(12),
        "<results>/figures/skurowski_fig12.png",
        of_figure(13),
        "<results>/figures/skurowski_fig13.png",
    log:
        "<logs>/skurowski_families.log",
    benchmark:
        "<benchmarks>/skurowski_families.tsv"
    threads: 1
    params:
        code=source("skurowski_families.py", "noise", "present"),
        rows=lambda wildcards: columns_of(accepted_rows("skurowski2019"), *SUBSET),
    message:
        "Figures 12 and 13 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_families.py"


rule skurowski_repaired:
    input:
        checks=checks("skurowski2019-repaired"),
        allan=lambda wildcards: [cleaned_allan_of(name) for name in [*repaired(), *unrepaired()]],
    output:
        report(
            "<results>/figures/skurowski_figA1.svg",
            caption="../report/skurowski_families.rst",
            category="2 Skurowski & Pawlyta 2019",
            labels={"result": "Figure A1: z1 after the repair"},
        ),
        "<results>/figures/skurowski_figA1.png",
    log:
        "<logs>/skurowski_repaired.log",
    benchmark:
        "<benchmarks>/skurowski_repaired.tsv"
    threads: 1
    params:
        code=source("skurowski_families.py", "noise", "present"),
        rows=lambda wildcards: columns_of(map(row, repaired()), *SUBSET, "compare_with", "comment"),
        others=lambda wildcards: columns_of(map(row, unrepaired()), "recording", "twin"),
        left_out=lambda wildcards: twin_values(repaired(), "without_T_c_below_s"),
    message:
        "Figure A1 of Skurowski & Pawlyta 2019"
    script:
        "../scripts/skurowski_families.py"
