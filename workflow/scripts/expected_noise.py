"""expected.csv of every recording that the paper prints coefficients of: what S's estimator makes
of the published noise without chance.

Estimator `published`: the coefficients behind the twin and their Cramer-Rao bounds at its length;
`annealing-ant-colony`: the same fit as in noise.csv of the Allan variances of that model in
the form of the twin.
"""

from step import step

with step(snakemake) as log:
    from dataclasses import replace
    from pathlib import Path

    from mocap_metrology.common.files import write_csv
    from mocap_metrology.noise.fit import estimates
    from mocap_metrology.noise.fit import estimators as fit
    from mocap_metrology.noise.twins.published import published_row
    from mocap_metrology.settings import Settings

    params = snakemake.params
    for path in snakemake.output:
        recording = Path(path).parent.name
        subset, twin = params.subsets[recording], params.twins[recording]
        rate = twin.frame_rate_hz
        n = round(twin.duration_s * rate)
        settings = fit.NoiseSettings.of(Settings(**params.settings), rate, subset=subset)
        m = settings.averaging_factors(n)
        table = []
        for name, model in published_row(*subset).items():
            model = replace(model, form=params.forms[recording])
            estimate = fit.expected_estimate(model, m, n, rate, settings, name)
            table += estimates.rows(name, fit.published_estimate(model, n, rate))
            table += estimates.rows(name, estimate)
            log.info("%s %s: cost %.6g %s", recording, name, estimate.cost, estimate.note)
        write_csv(path, table)
