# Recordings of a group side by side: tables of every group, figures of two recordings or more.

OTHERS = "group != 'skurowski2019'"  # the figures of the paper itself are in skurowski.smk


rule group_tables:
    input:
        checks=checks(RECORDINGS, OF_GROUP),
        gaussian=collect("<results>/recordings/{row.recording}/gaussian.csv", row=accepted()),
        outliers=collect("<results>/recordings/{row.recording}/outliers.csv", row=accepted()),
        allan=collect("<results>/recordings/{row.recording}/allan_masked.parquet", row=accepted()),
        noise=collect("<results>/recordings/{row.recording}/noise.csv", row=accepted()),
        verdicts=collect("<results>/recordings/{row.recording}/verdict.json", row=accepted()),
    output:
        multiext("<results>/tables/{group}_subsets", ".csv", ".md"),
        multiext("<results>/tables/{group}_gaussian", ".csv", ".md"),
        multiext("<results>/tables/{group}_outliers", ".csv", ".md"),
        multiext("<results>/tables/{group}_allan", ".csv", ".md"),
        multiext("<results>/tables/{group}_noise", ".csv", ".md"),
        multiext("<results>/tables/{group}_summary", ".csv", ".md"),
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


promise(
    tables=collect_outputs(rules.group_tables.output, group=groups()),
    figures=together(
        collect_outputs(rules.families.output, group=groups(selection.several, OTHERS)),
        collect_outputs(rules.scaling.output, group=groups(selection.scaled, OTHERS)),
    ),
)


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


promise(
    tables=together(
        collect_outputs(rules.compare.output, group=groups(pairs)),
        collect_outputs(rules.trend.output, group=groups(selection.over_dates)),
        collect_outputs(rules.coherence.output, group=groups(selection.with_covariate)),
    ),
)


WITH_PLACE = accepted(selection.with_place)


rule orientation:
    input:
        trajectories="<results>/recordings/{recording}/trajectories.parquet",
        poses=branch(of_row(has_bodies), then=MEASURED_FILES),
    output:
        series="<results>/recordings/{recording}/orientation.parquet",
        allan="<results>/recordings/{recording}/allan_orientation.parquet",
        csv="<results>/recordings/{recording}/orientation.csv",
        svg=report(
            "<results>/recordings/{recording}/orientation.svg",
            caption="../report/caption.rst",
            category="5 Recordings",
            subcategory="{recording}",
            labels={"result": "orientation: Allan deviation of a rotation vector"},
        ),
        png="<results>/recordings/{recording}/orientation.png",
    log:
        "<logs>/orientation/{recording}.log",
    benchmark:
        "<benchmarks>/orientation/{recording}.tsv"
    resources:
        mem_mb=memory(1000, arrays=9),
        runtime=minutes(30, seconds=3.0),
    params:
        code=source("orientation.py", "io", "noise", "present"),
        caption=captions.ORIENTATION,
        contents=contents(selection.paths),
        cluster=cell("cluster"),
        accept_truncated=cell("accept_truncated"),
        names=cell("column_names"),
        allan=config["allan"],
        hampel=config["hampel"],
        mask_sigma=config["noise"]["mask_sigma"],
    message:
        "{wildcards.recording}: noise of the orientation"
    script:
        "../scripts/orientation.py"


rule place:
    input:
        "<results>/recordings/{recording}/clean.parquet",
    output:
        csv="<results>/recordings/{recording}/place.csv",
        md="<results>/recordings/{recording}/place.md",
        svg=report(
            "<results>/recordings/{recording}/place.svg",
            caption="../report/caption.rst",
            category="5 Recordings",
            subcategory="{recording}",
            labels={"result": "by place: length of a moving pair over the volume"},
        ),
        png="<results>/recordings/{recording}/place.png",
    log:
        "<logs>/place/{recording}.log",
    benchmark:
        "<benchmarks>/place/{recording}.tsv"
    resources:
        mem_mb=memory(1000, arrays=12),
        runtime=minutes(30, seconds=0.9),
    params:
        code=source("place.py", "coordinates.py", "noise", "present"),
        caption=captions.PLACE,
        place=config["place"],
    message:
        "{wildcards.recording}: noise by place"
    script:
        "../scripts/place.py"


rule places:
    input:
        allan=collect("<results>/recordings/{row.recording}/allan_masked.parquet", row=WITH_PLACE),
        clean=collect("<results>/recordings/{row.recording}/clean.parquet", row=WITH_PLACE),
    output:
        csv="<results>/tables/{group}_places.csv",
        md="<results>/tables/{group}_places.md",
    log:
        "<logs>/places/{group}.log",
    benchmark:
        "<benchmarks>/places/{group}.tsv"
    resources:
        mem_mb=memory(1000),
        runtime=minutes(10),
    params:
        code=source("places.py", "noise", "present"),
        rows=columns("recording", "place", "markers", of=WITH_PLACE),
        sources=column("source", of=WITH_PLACE),
    message:
        "{wildcards.group}: noise by place"
    script:
        "../scripts/places.py"


promise(
    tables=collect_outputs(rules.places.output, group=groups(selection.with_place)),
    figures=together(
        collect_outputs(rules.orientation.output, recording=accepted(turned, EVERY)),
        collect_outputs(rules.place.output, recording=accepted(moved, EVERY)),
    ),
)


SUBSETS = accepted(selection.subsets)


rule cameras:
    input:
        raw=collect("<results>/recordings/{row.recording}/trajectories.parquet", row=SUBSETS),
        covariance=collect("<results>/recordings/{row.recording}/covariance.csv", row=SUBSETS),
        noise=collect("<results>/recordings/{row.recording}/noise.csv", row=SUBSETS),
    output:
        csv="<results>/tables/{group}_cameras.csv",
        md="<results>/tables/{group}_cameras.md",
        law="<results>/tables/{group}_camera_law.csv",
        law_md="<results>/tables/{group}_camera_law.md",
        json="<results>/tables/{group}_cameras.json",
        svg=report(
            "<results>/figures/{group}_cameras.svg",
            caption="../report/caption.rst",
            category="4 Groups",
            subcategory="{group}",
            labels={"result": "cameras: noise with each camera added"},
        ),
        png="<results>/figures/{group}_cameras.png",
    log:
        "<logs>/cameras/{group}.log",
    benchmark:
        "<benchmarks>/cameras/{group}.tsv"
    resources:
        mem_mb=memory(1500),
        runtime=minutes(30),
    params:
        code=source("cameras.py", "noise", "present"),
        caption=captions.CAMERAS,
        takes=accepted(selection.takes),
        rows=columns("recording", "camera_type", "camera_ids", of=SUBSETS),
        cameras=config["cameras"],
        mask_sigma=config["noise"]["mask_sigma"],
        half_window_s=config["hampel"]["half_window_s"],
    message:
        "{wildcards.group}: noise by number of cameras"
    script:
        "../scripts/cameras.py"


promise(
    tables=collect_outputs(rules.cameras.output, group=groups(selection.subsets)),
)
