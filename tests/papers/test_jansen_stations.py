"""J's tables by the number of second-generation stations."""

import numpy as np
import pytest

from mocap_metrology.papers.jansen import cells, stations_tables


def record(setup: str, errors: dict[str, list[float] | None]) -> dict:
    """Errors (6,) of each station but the reference, None of one without a pose."""
    poses = [{"errors_mm": e[:3], "errors_deg": e[3:]} for e in errors.values() if e]
    places = iter(range(len(poses)))
    chosen = {name: next(places) if e else None for name, e in errors.items()}
    stations = {name: {"id": None, "mode": name} for name in ("0", *errors)}
    document = {"stations": stations, "chosen": chosen, "poses": poses}
    return {"calibration": "c", "setup": setup, "source": "twin", "pose": document}


def test_errors_are_summed_over_stations_and_recordings() -> None:
    """Against numpy: two setups of three stations, one with a station that is lost once."""
    rng = np.random.default_rng(4)
    a, b = rng.normal(size=(4, 2, 6)), rng.normal(size=(3, 2, 6))
    records = [record("v2-real-3-1", {"1": x[0].tolist(), "2": x[1].tolist()}) for x in a]
    records += [record("v2-real-3-2", {"1": x[0].tolist(), "2": x[1].tolist()}) for x in b]
    records[-1] = record("v2-real-3-2", {"1": b[2, 0].tolist(), "2": None})
    found = {(r["table"], r["quantity"]): r for r in stations_tables(records)}
    kept = np.array([*b[:2].reshape(-1, 6), b[2, 0]])
    mae = (np.abs(a).mean(axis=(0, 1)) + np.abs(kept).mean(axis=0)) / 2
    sd_b = (b[:, 0].std(axis=0, ddof=1) + b[:2, 1].std(axis=0, ddof=1)) / 2
    sd = (a.std(axis=0, ddof=1).mean(axis=0) + sd_b) / 2
    for table, values in ((1, mae), (2, sd)):
        got = [found[table, q]["regenerated"] for q in ("x_mm", "y_mm", "z_mm")]
        np.testing.assert_allclose(got, values[:3])
    one = found[1, "alpha_deg"]
    assert (one["stations"], one["n_setups"], one["n"]) == (3, 2, 7)
    # J's measured setups (Tables I and II)
    assert one["published"] == pytest.approx(1.19) and found[1, "x_mm"]["published"] == 20.6


def test_a_line_for_each_number_of_stations_below_those_of_the_paper() -> None:
    six = [1.0, 2.0, 3.0, 0.1, 0.2, 0.3]
    records = [record("v2-real-2-1", {"1": six})] * 2
    records += [
        record("v2-real-4-1", dict.fromkeys("123", six)),
        record("v2-ideal-2-1", {"1": six}),
    ]
    lines = cells(list(stations_tables(records)))
    assert [line[:3] for line in lines] == [
        [1, "Overall", "J: 2 (V1)"], [1, "Overall", 2], [1, "Overall", 4],
        [2, "Average", "J: 2 (V1)"], [2, "Average", 2], [2, "Average", 4],
        [3, "MAE", "J: 2 (V1)"], [3, "MAE", 2],
        [3, "Average SD", "J: 2 (V1)"], [3, "Average SD", 2],
    ]  # fmt: skip
    assert lines[1][3:] == ["1.00", "2.00", "3.00", "0.100", "0.200", "0.300", 2]
