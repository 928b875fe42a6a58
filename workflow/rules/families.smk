# Recordings side by side: tables of every group, figures of groups of two recordings or more.

OTHERS = "group != 'skurowski2019'"  # the figures of the paper itself are in skurowski.smk


rule group_tables:
    input:
        checks=checks(RECORDINGS, OF_GROUP),
        gaussian=collect("<results>/recordings/{row.recording}/gaussian.csv", row=accepted()),
        outliers=collect("<results>/recordings/{row.recording}/outliers.csv", row=accepted()),
        allan=collect("<results>/recordings/{row.recording}/allan_masked.parquet", row=accepted()),
        noise=collect("<results>/recordings/{row.recording}/noise.csv", row=accepted()),
    output:
        multiext(
            "<results>/tables/{group}",
            "_subsets.csv",
            "_subsets.md",
            "_gaussian.csv",
            "_gaussian.md",
            "_outliers.csv",
            "_outliers.md",
            "_allan.csv",
            "_allan.md",
            "_noise.csv",
            "_noise.md",
        ),
    log:
        "<logs>/group_tables/{group}.log",
    benchmark:
        "<benchmarks>/group_tables/{group}.tsv"
    resources:
        mem_mb=memory(500),
        runtime=minutes(10),
    params:
        code=source("group_tables.py", "noise", "present"),
        rows=columns(*SUBSET, "camera_ids", "comment", of=accepted()),
    message:
        "{wildcards.group}: tables of the group"
    script:
        "../scripts/group_tables.py"


rule families:
    input:
        checks=checks(RECORDINGS, OF_GROUP),
        allan=collect("<results>/recordings/{row.recording}/allan_masked.parquet", row=accepted()),
        noise=collect("<results>/recordings/{row.recording}/noise.csv", row=accepted()),
    output:
        report(
            "<results>/figures/{group}_adev.svg",
            caption="../report/caption.rst",
            category="4 Groups",
            subcategory="{group}",
            labels={"result": "Allan deviation: all recordings, by series"},
        ),
        "<results>/figures/{group}_adev.png",
        report(
            "<results>/figures/{group}_coefficients.svg",
            caption="../report/caption.rst",
            category="4 Groups",
            subcategory="{group}",
            labels={"result": "power-law noise: coefficients with intervals"},
        ),
        "<results>/figures/{group}_coefficients.png",
        report(
            "<results>/figures/{group}_correlated.svg",
            caption="../report/caption.rst",
            category="4 Groups",
            subcategory="{group}",
            labels={"result": "correlated noise: amplitudes and correlation times"},
        ),
        "<results>/figures/{group}_correlated.png",
    log:
        "<logs>/families/{group}.log",
    benchmark:
        "<benchmarks>/families/{group}.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(10),
    params:
        code=source("families.py", "noise", "present"),
        caption=captions.FAMILIES,
        rows=columns(*SUBSET, of=accepted()),
    message:
        "{wildcards.group}: figures of the group"
    script:
        "../scripts/families.py"


# The paper's Figure 11 for any group with subsets of cameras.
rule scaling:
    input:
        checks=checks(RECORDINGS, OF_GROUP),
        gaussian=collect("<results>/recordings/{row.recording}/gaussian.csv", row=accepted()),
    output:
        report(
            "<results>/figures/{group}_scaling.svg",
            caption="../report/caption.rst",
            category="4 Groups",
            subcategory="{group}",
            labels={"result": "Spread: over the number of cameras"},
        ),
        "<results>/figures/{group}_scaling.png",
    log:
        "<logs>/scaling/{group}.log",
    benchmark:
        "<benchmarks>/scaling/{group}.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(10),
    params:
        code=source("scaling.py", "noise", "present"),
        caption=captions.SCALING,
        rows=columns(*SUBSET, of=accepted()),
    message:
        "{wildcards.group}: spread over the number of cameras"
    script:
        "../scripts/scaling.py"


rule families_results:
    input:
        tables=collect_outputs(rules.group_tables.output, group=groups()),
        figures=together(
            collect_outputs(rules.families.output, group=groups(selection.several, OTHERS)),
            collect_outputs(rules.scaling.output, group=groups(selection.scaled, OTHERS)),
        ),
