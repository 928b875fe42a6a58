"""allan.parquet -> expected.csv: what S's estimator makes of the published noise without chance.

Estimator `published`: the coefficients behind the twin and their Cramer-Rao bounds at its length;
`annealing-ant-colony`: the same fit as in noise.csv of the Allan variances of that model in
the form of the twin.
"""

from step import step

with step(snakemake) as log:
    from dataclasses import replace

    from mocap_metrology.common.files import read_table, write_csv
    from mocap_metrology.noise.fit import estimates
    from mocap_metrology.noise.fit.estimators import (
        NoiseSettings,
        expected_estimate,
        published_estimate,
    )
    from mocap_metrology.noise.twins.published import published_row

    given = snakemake.params
    allan, origin = read_table(snakemake.input[0])
    rate = origin["frame_rate_hz"]
    (twin,) = given.twin.values()
    n = round(twin.duration_s * rate)
    settings = NoiseSettings.of(given.settings, rate, subset=given.subset)
    table = []
    for name, model in published_row(*given.subset).items():
        m = allan["m"][(allan["series"] == name) & (allan["estimator"] == "oadev")]
        model = replace(model, form=given.form)
        found = expected_estimate(model, m, n, rate, settings, name)
        table += estimates.rows(name, published_estimate(model, n, rate))
        table += estimates.rows(name, found)
        log.info("%s: cost %.6g %s", name, found.cost, found.note)
    write_csv(snakemake.output[0], table)
