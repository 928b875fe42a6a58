"""Figures: what they show, that their bytes repeat, and that odd recordings are drawn too."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from functools import partial
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.text import Text
from PIL import Image

from mocap_metrology.present.decimate import columns, log_bins, runs, standouts
from mocap_metrology.present.recording import allan_figure, psd_figure, trajectory_figure
from mocap_metrology.present.style import LOOKS, save_figure, styled, wrap

RATE = 120.0
NINE_HOURS = 3_888_000
ODD_TEXT = "a$b$_c^{2} -- <&> \\frac \x00\n\t é µ " + "unbroken" * 40
pytestmark = pytest.mark.filterwarnings("error")


def recording(n: int, n_markers: int = 2, pairs: bool = True, seed: int = 1):
    """Raw, clean, outliers of white noise with spikes, in mm."""
    rng = np.random.default_rng(seed)
    names = [f"{axis}{k}" for k in range(1, n_markers + 1) for axis in "xyz"]
    names += ["L"] if pairs else []
    clean = {name: 100.0 + 0.02 * rng.standard_normal(n) for name in names}
    raw = {name: values.copy() for name, values in clean.items()}
    outliers = {name: rng.random(n) < 0.01 for name in names}
    for name in names:
        raw[name][outliers[name]] += 0.5
    return raw, clean, outliers


def allan_columns(names, n: int = 40, estimators=("oadev",)):
    """Columns of allan.parquet for white noise and a random walk, in closed form."""
    rows = {"series": [], "estimator": [], "m": [], "tau_s": [], "adev_mm": [], "edf": []}
    m = np.unique(np.geomspace(1, 10_000, n).astype(int))
    for name in names:
        for estimator in estimators:
            tau = m / RATE
            rows["series"] += [name] * m.size
            rows["estimator"] += [estimator] * m.size
            rows["m"].append(m)
            rows["tau_s"].append(tau)
            rows["adev_mm"].append(np.sqrt(1e-6 / tau + 1e-8 * tau))
            rows["edf"].append(np.full(m.size, 9.0))
    out = {k: np.array(v) if k in ("series", "estimator") else _join(v) for k, v in rows.items()}
    out["adev_lower_mm"], out["adev_upper_mm"] = 0.8 * out["adev_mm"], 1.4 * out["adev_mm"]
    return out


def psd_columns(names, n: int = 2000):
    f_hz = np.arange(n) * RATE / 2 / n
    return {
        "series": np.repeat(np.array(names, dtype=str), n),
        "f_hz": np.tile(f_hz, len(names)),
        "psd_mm2_hz": np.full(n * len(names), 1e-5),
    }


def _join(parts):
    return np.concatenate(parts) if parts else np.array([])


def every_text(figure) -> list[str]:
    """All text that the figure shows."""
    found = [text.get_text() for text in figure.texts]
    for axes in figure.axes:
        found += [text.get_text() for text in axes.texts]
        found += [axes.get_xlabel(), axes.get_ylabel()]
    return [text for text in found if text]


def check(figure, draw: bool = True) -> None:
    """Draw at a low resolution; no text leaves the page, labels of an axis do not touch."""
    figure.set_dpi(80)
    canvas = FigureCanvasAgg(figure)
    with styled():
        if draw:
            canvas.draw()
        extent = partial(Text.get_window_extent, renderer=canvas.get_renderer())
        page, slack = figure.bbox, 0.01 * figure.bbox.width  # hinting widens small text
        for text in [text for owner in (figure, *figure.axes) for text in owner.texts]:
            box = extent(text)
            assert page.x0 <= box.x0 and box.x1 <= page.x1 + slack, text.get_text()
            assert page.y0 <= box.y0 and box.y1 <= page.y1, text.get_text()
        for axis in [axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]:
            if not axis.get_visible() or not axis.axes.axison:
                continue
            labels = [
                axis.label,
                *(t.label1 for t in axis.get_major_ticks() if t.label1.get_visible()),
            ]
            boxes = [extent(text) for text in labels if text.get_text()]
            for one, other in combinations(boxes, 2):
                # Squeezed by half a point, for the box holds room for descenders
                assert not one.padded(-1).overlaps(other.padded(-1)), labels


def check_saved(figure, folder: Path) -> Path:
    """Save: both files are there, the SVG well-formed and small. Return the PNG."""
    check(figure)
    folder.mkdir(exist_ok=True)
    svg, png = save_figure(figure, folder / "figure")
    assert sorted(path.name for path in folder.iterdir()) == ["figure.png", "figure.svg"]
    ElementTree.parse(svg)
    assert svg.stat().st_size < 1_000_000
    return png


# ---- decimation


def test_columns_are_what_numpy_finds_one_by_one():
    rng = np.random.default_rng(2)
    values = 1e4 + rng.standard_normal(300_001)
    values[1000:1700], values[5], values[250_000] = np.nan, np.inf, np.nan
    found = columns(values, 883)
    assert found.first[0] == 0 and found.stop[-1] == values.size
    assert np.array_equal(found.first[1:], found.stop[:-1])
    for k in range(883):
        part = values[found.first[k] : found.stop[k]]
        part = part[np.isfinite(part)]
        assert found.n_valid[k] == part.size
        if part.size:
            assert (found.low[k], found.high[k]) == (part.min(), part.max())
            assert found.mean[k] == pytest.approx(part.mean(), abs=1e-9)
        else:
            assert np.isnan([found.low[k], found.high[k], found.mean[k]]).all()


@pytest.mark.parametrize("at", [0, 1_234_567, NINE_HOURS - 1])
def test_one_sample_in_nine_hours_is_kept(at):
    values = np.zeros(NINE_HOURS, dtype=np.float32)
    values[at] = 1
    found = columns(values, 900)
    column = at * 900 // NINE_HOURS
    assert found.high[column] == 1 and np.count_nonzero(found.high) == 1
    assert found.mean[column] == pytest.approx(1 / 4320, rel=1e-6)


def test_standouts_hold_the_largest_and_are_few():
    rng = np.random.default_rng(3)
    position = np.sort(rng.choice(NINE_HOURS, 13_000, replace=False))
    deviation = rng.exponential(1.0, position.size)
    drawn = standouts(deviation, position, NINE_HOURS, 200, 200)
    assert drawn.size <= 400 and np.all(np.diff(drawn) > 0)
    assert set(np.argsort(deviation)[-200:]) <= set(drawn.tolist())
    stretch = position * 200 // NINE_HOURS
    assert all(
        deviation[drawn][stretch[drawn] == k].max() == deviation[stretch == k].max()
        for k in np.unique(stretch)
    )
    assert np.array_equal(standouts(deviation[:9], position[:9], NINE_HOURS, 5, 5), range(9))


def test_log_bins_keep_a_narrow_line_and_sparse_points():
    f_hz = np.arange(36_001) / 600
    psd = np.full(f_hz.size, 1e-5)
    psd[9_000] = 1.0  # 15 Hz
    bins = log_bins(f_hz, psd, 40)
    peak = int(np.argmax(bins.high))
    assert bins.high[peak] == 1.0 and abs(bins.centre[peak] / 15 - 1) < 0.06
    assert np.all(bins.median == 1e-5) and bins.centre.size < 200
    sparse = log_bins(f_hz[:10], np.arange(10.0), 40)
    assert np.allclose(sparse.centre, f_hz[1:10]) and np.array_equal(sparse.median, range(1, 10))


def test_runs():
    assert runs(np.array([1, 0, 1, 1], dtype=bool)).tolist() == [[0, 1], [2, 4]]
    assert runs(np.zeros(3, dtype=bool)).shape == (0, 2)


# ---- files


def test_a_failed_figure_leaves_nothing(tmp_path, monkeypatch):
    figure = psd_figure(psd_columns(["x1"]), "t", "n")
    save = type(figure).savefig

    def fails_on_png(self, path, format, **options):
        save(self, path, format="svg", **options | {"metadata": None})
        if format == "png":
            raise OSError("disk full")

    monkeypatch.setattr(type(figure), "savefig", fails_on_png)
    with pytest.raises(OSError, match="disk full"):
        save_figure(figure, tmp_path / "figure")
    assert not list(tmp_path.iterdir())


def test_a_figure_saved_twice_has_the_same_bytes(tmp_path):
    figure = allan_figure(allan_columns(["x1", "y1", "L"]), "t", "n")
    first = [path.read_bytes() for path in save_figure(figure, tmp_path / "a.b")]
    again = [path.read_bytes() for path in save_figure(figure, tmp_path / "a.b")]
    assert first == again and (tmp_path / "a.b.svg").exists()


DRAW = """
import sys
sys.path.insert(0, {folder!r})
from test_figures import allan_columns, recording, RATE
from mocap_metrology.present.recording import allan_figure, trajectory_figure
from mocap_metrology.present.style import save_figure
save_figure(allan_figure(allan_columns(["x1", "y1", "L"]), "t", "n"), "allan")
save_figure(trajectory_figure(*recording(9000), RATE, "t", "n"), "trajectory")
assert "matplotlib.pyplot" not in sys.modules
"""


def test_bytes_do_not_depend_on_where_and_when(tmp_path):
    running = []
    surroundings = (
        {"PYTHONHASHSEED": "1", "TZ": "UTC", "LC_ALL": "C.UTF-8"},
        {"PYTHONHASHSEED": "2", "TZ": "Asia/Tokyo", "SOURCE_DATE_EPOCH": "1"},
    )
    rc = tmp_path / "matplotlibrc"
    rc.write_text("lines.linewidth: 5\nfont.size: 20\nsvg.fonttype: none\nsavefig.dpi: 50\n")
    for k, extra in enumerate(surroundings):
        folder = tmp_path / str(k)
        folder.mkdir()
        environment = os.environ | extra | ({"MATPLOTLIBRC": str(rc)} if k else {})
        script = DRAW.format(folder=str(Path(__file__).parent))
        command = [sys.executable, "-c", script]
        running.append(subprocess.Popen(command, cwd=folder, env=environment))
    assert [process.wait() for process in running] == [0, 0]
    files = [sorted((tmp_path / str(k)).iterdir()) for k in range(2)]
    assert [path.name for path in files[0]] == [path.name for path in files[1]]
    assert len(files[0]) == 4
    digests = [[hashlib.sha256(path.read_bytes()).digest() for path in side] for side in files]
    assert digests[0] == digests[1]


# ---- what is shown


def test_a_spike_of_one_sample_in_nine_hours_shows(tmp_path):
    rng = np.random.default_rng(4)
    values = 0.02 * rng.standard_normal(NINE_HOURS)
    with_spike = values.copy()
    at = NINE_HOURS // 3
    with_spike[at] = 0.2
    nothing = {"x1": np.zeros(NINE_HOURS, dtype=bool)}
    images = []
    for k, series in enumerate((values, with_spike)):
        # One axis for both: a corner sample as high as the spike, at the very end
        series[-1] = 0.21
        figure = trajectory_figure({"x1": series}, {"x1": series}, nothing, RATE, "t", "")
        image = Image.open(check_saved(figure, tmp_path / str(k))).convert("L")
        images.append(np.asarray(image))
    changed = np.abs(images[0].astype(int) - images[1]) > 40
    rows, places = np.nonzero(changed[:, : changed.shape[1] * 6 // 10])
    assert np.ptp(rows) > 0.25 * changed.shape[0] * 0.5  # from the noise up to 0.2 mm
    assert np.ptp(places) <= 6  # and no wider than a column
    box = figure.axes[-1].get_position()
    assert places.mean() / changed.shape[1] == pytest.approx(box.x0 + box.width / 3, abs=0.004)


def test_real_numbers_from_series_to_figures():
    from mocap_metrology.noise.allan import averaging_factors
    from mocap_metrology.noise.confidence import allan_curve
    from mocap_metrology.noise.hampel import hampel
    from mocap_metrology.noise.spectrum import welch

    raw, _, _ = recording(1800)
    raw["y2"][700:1100] = np.nan
    cleaned = {name: hampel(values, 60) for name, values in raw.items()}
    allan = {key: [] for key in allan_columns(["x1"])}
    psd = {key: [] for key in psd_columns(["x1"])}
    for name, one in cleaned.items():
        curve = allan_curve(one.values, RATE, averaging_factors(one.values.size))
        rows = (curve.m, curve.tau_s, curve.deviation, curve.edf, curve.lower, curve.upper)
        for key, values in zip(
            allan, ([name] * curve.m.size, ["oadev"] * curve.m.size, *rows), strict=True
        ):
            allan[key].append(values)
        spectrum = welch(one.values, RATE)
        for key, values in zip(
            psd, ([name] * spectrum.f_hz.size, spectrum.f_hz, spectrum.psd), strict=True
        ):
            psd[key].append(values)
    figures = (
        allan_figure({key: _join(v) for key, v in allan.items()}, "A", "n", confidence=0.683),
        psd_figure({key: _join(v) for key, v in psd.items()}, "P", "n"),
        trajectory_figure(
            raw,
            {name: one.values for name, one in cleaned.items()},
            {name: one.outlier for name, one in cleaned.items()},
            RATE,
            "T",
            "n",
        ),
    )
    for figure in figures:
        check(figure)
    shown = every_text(figures[0])
    assert {"Averaging time τ (s)", "Allan deviation (mm)", "68.3 % interval"} <= set(shown)
    assert {"Frequency (Hz)", "PSD (mm²/Hz)"} <= set(every_text(figures[1]))
    assert {"Time (s)", "x1 (µm)", "L (µm)"} <= set(every_text(figures[2]))
    n_y2 = int(cleaned["y2"].outlier.sum())
    assert any(
        f"replaced {n_y2} " in t and "missing 400 (22 %)" in t for t in every_text(figures[2])
    )


def test_colours_differ_in_lightness():
    """CIE L* of the three coordinates, at least 14 apart: enough for a grey print."""
    lightness = []
    for look in LOOKS.values():
        linear = [
            c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(look.colour)
        ]
        lightness.append(116 * np.dot([0.2126, 0.7152, 0.0722], linear) ** (1 / 3) - 16)
    assert np.diff(sorted(lightness)).min() > 14 and max(lightness) < 75
    assert (
        len({look.marker for look in LOOKS.values()} | {str(v.dashes) for v in LOOKS.values()}) == 6
    )


@pytest.mark.parametrize("names", [["x1"], ["x1", "x2", "L"], ["x1", "x2", "x3", "L"]])
def test_slopes_of_the_key_are_those_of_the_panels(names):
    figure = allan_figure(allan_columns(names), "t", "n")
    panel, key = figure.axes[0], figure.axes[-1]
    ends = panel.transData.transform([(1.0, 1e-2), (100.0, 1e-3)])  # slope -1/2
    on_paper = np.diff(ends[:, 1]) / np.diff(ends[:, 0])
    lines = [key.transData.transform(line.get_xydata()) for line in key.lines]
    starts = [tuple(line[0]) for line in lines]
    fan = [line for line in lines if starts.count(tuple(line[0])) == 5]
    rises = [(y[1] - y[0]) / (x[1] - x[0]) for x, y in (line.T for line in fan)]
    assert len(rises) == 5 and np.isclose(rises, on_paper).sum() == 1


def test_a_long_note_is_printed_whole():
    note = " ".join(f"word{k}" for k in range(300))
    figure = psd_figure(psd_columns(["x1"]), "title " * 40, note)
    assert note in " ".join(every_text(figure)).replace("\n", " ")
    assert wrap("", 8, 50) == [] and "".join(wrap("a" * 500, 8, 50)) == "a" * 500


# ---- odd recordings


def _gaps(data):
    for series in data[:2]:
        series["x1"][10:20] = np.nan
        series["y2"][:] = np.nan
        series["z1"][1::2] = np.nan
        series["z2"][5] = np.inf


def _constant(data):
    for series in data[:2]:
        series["x1"][:] = 3.0
        series["L"][:] = 0.0


def _lone_frame(data):
    for series in data[:2]:
        series["x1"][:] = np.nan
        series["x1"][7] = 1.0


TRAJECTORIES = {
    "one marker": (recording(500, 1, pairs=False), None),
    "29 frames": (recording(29), _gaps),
    "one frame": (recording(1), None),
    "no frame": (recording(0), None),
    "no series": (({}, {}, {}), None),
    "gaps": (recording(9000), _gaps),
    "constant": (recording(9000), _constant),
    "constant and short": (recording(200), _constant),
    "lone frame": (recording(9000), _lone_frame),
    "six markers": (recording(900, 6), _gaps),
    "many markers": (recording(300, 40), _gaps),
}


@pytest.mark.parametrize("case", TRAJECTORIES)
def test_odd_trajectories(case):
    data, change = TRAJECTORIES[case]
    if change is not None:
        change(data)
    figure = trajectory_figure(*data, RATE, ODD_TEXT, ODD_TEXT)
    check(figure)
    shown = every_text(figure)
    assert ("no valid samples" in shown) >= (case in ("gaps", "29 frames", "many markers"))


def test_masked_outliers_are_drawn():
    raw, clean, outliers = recording(9000)
    for name in raw:
        clean[name][outliers[name]] = np.nan
    raw["x1"][:200], clean["x1"][:200], outliers["x1"][:200] = 7.0, np.nan, True
    check(trajectory_figure(raw, clean, outliers, RATE, "t"))


def test_odd_names(tmp_path):
    raw, clean, outliers = recording(300, 1, pairs=False)
    names = ["L_1_3", "_hidden", "$x_1$", "µ" * 60]
    for data in (raw, clean, outliers):
        for name in names:
            data[name] = data["x1"]
    check(trajectory_figure(raw, clean, outliers, RATE, "t", "n"))
    for k, figure in enumerate(
        (allan_figure(allan_columns(list(raw)), "t"), psd_figure(psd_columns(list(raw)), "t"))
    ):
        check_saved(figure, tmp_path / str(k))
        assert {"L_1_3", "_hidden", "$x_1$"} <= set(every_text(figure))


def _names(n_markers, pairs=()):
    return [f"{a}{k}" for k in range(1, n_markers + 1) for a in "xyz"] + list(pairs)


@pytest.mark.parametrize("n_markers", [1, 2, 3, 5, 6, 40])
@pytest.mark.parametrize("n_pairs", [0, 2, 9])
def test_layouts(n_markers, n_pairs):
    names = _names(n_markers, [f"L_{k}_{k + 1}" for k in range(n_pairs)])
    figure = allan_figure(allan_columns(names), "t", "n")
    check(figure, draw=n_markers == 5)
    n_panels = (n_markers if n_markers <= 6 else 3) + (n_pairs > 0)
    assert len(figure.axes) == n_panels + 1  # and the key


def test_20_panels_stay_small(tmp_path):
    data = recording(4000, 6)
    for part in data:
        part["L_1_3"] = part["L"]
    figure = trajectory_figure(*data, RATE, "t", "n")
    assert len(figure.axes) == 21  # and the key
    check_saved(figure, tmp_path)
    # Only the dense parts are an image: every tick label is drawn as text
    assert (tmp_path / "figure.svg").read_text().count("<!-- 0 -->") > 20


@pytest.mark.parametrize(
    "case", ["infinite", "few", "zero", "nan", "tiny", "missing", "none", "three"]
)
def test_odd_allan_curves(case):
    names = _names(2, ["L"])
    data = allan_columns([] if case == "none" else names)
    chosen = data["series"] == "x1"
    if case == "infinite":
        data["adev_upper_mm"][5:] = np.inf
        data["adev_lower_mm"][::3] = np.nan
    elif case == "few":
        data = {key: values[::40] for key, values in data.items()}
    elif case == "zero":
        for key in ("adev_mm", "adev_lower_mm", "adev_upper_mm"):
            data[key][chosen] = 0.0
    elif case == "nan":
        data["adev_mm"][:] = np.nan
    elif case == "tiny":
        data["adev_mm"][chosen] = 1e-17
    elif case == "missing":
        data = {key: values[~chosen] for key, values in data.items()}
    elif case == "three":
        data = allan_columns(names, estimators=("oadev", "mdev", "hdev"))
    figure = allan_figure(data, ODD_TEXT, ODD_TEXT, expected=names)
    check(figure)
    said = {"zero": "x1: zero", "tiny": "x1: below the axis", "missing": "x1: no valid samples"}
    if case in said:
        assert said[case] in every_text(figure)
    if case in ("nan", "none"):
        assert every_text(figure).count("no valid samples") == 3
    if case == "three":
        assert {"mdev", "hdev"} <= set(every_text(figure))


def test_all_zero_is_not_no_data():
    data = allan_columns(["x1", "L"])
    data["adev_mm"][data["series"] == "L"] = 0.0
    assert "all zero" in every_text(allan_figure(data, "t"))


@pytest.mark.parametrize("span", [1.2, 3.0, 30.0, 1e3, 1e6, 1e12])
def test_ticks_of_any_span(span):
    data = psd_columns(["x1", "x2", "L"])
    data["psd_mm2_hz"] = np.geomspace(3e-7, 3e-7 * span, data["f_hz"].size)
    figure = psd_figure(data, "t")
    check(figure)
    ticks = [label.get_text() for label in figure.axes[0].get_yticklabels()]
    assert 2 <= len(ticks) <= 14 and any(text.startswith("10") for text in ticks)


@pytest.mark.parametrize("case", ["zero", "nan", "short", "none"])
def test_odd_spectra(case):
    names = _names(1)
    data = psd_columns([] if case == "none" else names, n=9 if case == "short" else 2000)
    if case == "zero":
        data["psd_mm2_hz"][data["series"] == "y1"] = 0.0
    elif case == "nan":
        data["psd_mm2_hz"][:] = np.nan
    figure = psd_figure(data, ODD_TEXT, ODD_TEXT)
    check(figure)
    if case == "zero":
        assert "y1: zero" in every_text(figure)
