# Targets: results of all SUBJECTS, and a gate. A target names its results itself besides the gate,
# as Snakemake does not make a deleted file again that only a finished gate needs.

PARTS = ("recordings", "calibrations", "tables", "figures")
TARGETS = {part: results_of(part) for part in PARTS} | {"all": results_of(*PARTS, "pages")}


# The gate runs last. It prints one line for each refused recording and fails if there is one.
rule gate:
    input:
        # Recordings and calibrations ask nothing of each other
        checks=branch(
            lambda wildcards: wildcards.target,
            cases={"recordings": checks(RECORDINGS), "calibrations": checks(CALIBRATIONS)},
            otherwise=checks(RECORDINGS) + checks(CALIBRATIONS),
        ),
        results=branch(lambda wildcards: wildcards.target, cases=TARGETS),
    output:
        "<results>/gate/{target}.json",
    log:
        "<logs>/gate/{target}.log",
    retries: 0  # what is refused stays so
    localrule: True
    resources:
        **cost(500, 10),
    params:
        code=source("gate.py"),
    message:
        "Checking for refused recordings: correct the named files, or remove their rows, and run again"
    script:
        "../scripts/gate.py"


for TARGET in PARTS:

    rule:
        name:
            TARGET
        input:
            gate(TARGET),
            TARGETS[TARGET],
