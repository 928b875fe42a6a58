# What can be asked for. Each target ends at a gate; see SUBJECTS for what it asks for.


# Last of all: one line for each refused recording, and a failure if there is any.
rule gate:
    input:
        # Recordings and calibrations ask nothing of each other
        checks=branch(
            lambda wildcards: wildcards.target,
            cases={"recordings": checks(RECORDINGS), "calibrations": checks(CALIBRATIONS)},
            otherwise=checks(RECORDINGS) + checks(CALIBRATIONS),
        ),
        results=branch(
            lambda wildcards: wildcards.target,
            cases={
                "recordings": results_of("recordings"),
                "calibrations": results_of("calibrations"),
                "tables": results_of("tables"),
                "figures": results_of("figures"),
                "all": results_of("recordings", "calibrations", "tables", "figures", "report"),
            },
        ),
    output:
        "<results>/gate/{target}.json",
    log:
        "<logs>/gate/{target}.log",
    benchmark:
        "<benchmarks>/gate/{target}.tsv"
    retries: 0  # what is refused stays so
    localrule: True
    resources:
        mem_mb=memory(500),
        runtime=minutes(10),
    params:
        code=source("gate.py"),
    message:
        "Looking for refused recordings: mend what is named, or take its row out, and run again"
    script:
        "../scripts/gate.py"


rule recordings:
    input:
        gate("recordings"),


rule calibrations:
    input:
        gate("calibrations"),


rule tables:
    input:
        gate("tables"),


rule figures:
    input:
        gate("figures"),
