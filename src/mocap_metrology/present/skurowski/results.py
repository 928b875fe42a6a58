"""Tables 3, 4 and A1-A3 and Figures 6 and 9-17 of S, from the results of the recordings of its
group."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from mocap_metrology.common.files import read_metadata, read_table
from mocap_metrology.common.hampel import SHORT_WINDOW, taken_at_most, white_level_kept
from mocap_metrology.common.types import Record
from mocap_metrology.noise.fit.estimates import read_noise
from mocap_metrology.noise.fit.estimators import NoiseSettings, regression
from mocap_metrology.noise.gaussian.moments import expected_moments
from mocap_metrology.noise.series import length_s
from mocap_metrology.noise.twins.published import published_gaussian
from mocap_metrology.noise.twins.twin import Twin
from mocap_metrology.papers import coefficient_tables, gaussian_table, subsets
from mocap_metrology.present import tables
from mocap_metrology.present.plot.figure import Picture
from mocap_metrology.present.skurowski import (
    allan_figures,
    appendix,
    coefficients,
    gaussian_figures,
)
from mocap_metrology.present.tables import Row
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import NINE_HOURS_S, duration_words
from mocap_metrology.settings import Settings

PAPER = captions.PAPERS["skurowski"]
SERIES = "z1"  # of Figures 6 and 17; S names none for 6, this one has a line and three bumps


@dataclass(frozen=True)
class Recordings:
    """Recordings of the group of S. folder: of the results of each; rows: of the sheet, by name;
    expected: names of those with an `expected.csv`; densities: those of Figures 9 and 10."""

    folder: Path
    rows: Mapping[str, Record]
    twins: Mapping[str, Twin]
    expected: Sequence[str]
    densities: Sequence[str]
    settings: Settings

    def file(self, recording: str, name: str) -> Path:
        return self.folder / recording / name

    @cached_property
    def coefficients(self) -> dict[str, list[Row]]:
        """Rows of Tables A1-A3, by number."""
        noise = {name: read_noise(self.file(name, "noise.csv")) for name in self.rows}
        expected = {name: read_noise(self.file(name, "expected.csv")) for name in self.expected}
        return {
            number: coefficient_tables.table_a(kind, self.rows, noise, expected)
            for kind, number in coefficient_tables.TABLES.items()
        }

    @cached_property
    def gaussian(self) -> dict[str, Row]:
        """The row of gaussian.csv of each recording, of axis x where it has one."""
        return {name: gaussian_row(self.file(name, "gaussian.csv"), "x") for name in self.rows}

    def sources(self, names: Sequence[str] = (), remark: str = "") -> tuple[str, str]:
        """Line at the foot of a figure of some of the recordings, or of all, and its remarks."""
        shown = {name: self.rows[name] for name in names or self.rows}
        paths = {name: self.file(name, "allan.parquet") for name in shown}
        lengths = {name: length_s(read_metadata(path)) for name, path in paths.items()}
        source, remarks = tables.sources(shown, lengths)
        return source, f"{remark} {remarks}".strip()


def gaussian_row(path: str | Path, axis: str) -> Row:
    """The first row of a gaussian.csv along that axis, else the first row."""
    rows: Any = tables.read(path).to_dict("records")
    return next((row for row in rows if row["axis"] == axis), rows[0] if rows else {})


def filter_sentence(origin: Record) -> str:
    """Effect of cleaning as in S on the Allan deviations of a table with these metadata."""
    hampel, half = origin["hampel"], origin["window_frames"] // 2
    n_sigma, action = hampel["n_sigma"], hampel["action"]
    if action == "off":
        return ""
    left = white_level_kept(n_sigma, max(half, SHORT_WINDOW), action)[1]
    most = 100 * taken_at_most(n_sigma, half, action)
    return captions.FILTER.format(n_sigma=n_sigma, percent=100 * (1 - left**0.5), most=most)


def _spread_sentence(twin: Twin | None) -> str:
    """Why the spread of a twin of Figure 9 is not Table 4's: its length and its coefficients."""
    if twin is None:
        return ""
    spread = []
    for seconds in (twin.duration_s, NINE_HOURS_S):
        moments = expected_moments(replace(twin, duration_s=seconds))
        one, two = (f"{1000 * moments[f'sigma_{k}']:.1f}" for k in (1, 2))
        spread.append(f"{one} and {two} µm over {duration_words(seconds)}")
    return captions.SPREAD.format(spread=", ".join(dict.fromkeys(spread)))


def write_tables(of: Recordings, folder: Path) -> Iterator[str]:
    """Write Tables 3, 4, A1-A3 and two that sum the last ones up; yields a line on each."""
    sources = {name: subsets.source_of(row) for name, row in of.rows.items()}
    sentence = tables.source_sentence(sources, of.settings.duration_s)
    form = f"{sentence} {appendix.FORM_WORDS[of.settings.twin_form]}"
    every = [row for rows in of.coefficients.values() for row in rows]
    levels = coefficient_tables.white_levels(every)
    counts = appendix.white_level_sentence(levels)
    support = coefficient_tables.support_counts(every)
    white = f"{counts} {captions.WHITE} {form}"
    for name, rows, title, caption in (
        (
            "table3",
            subsets.table_3(of.rows),
            "Table 3: camera subsets",
            f"{captions.TABLE_3} {sentence}",
        ),
        ("white_levels", levels, "Tables A1-A3: white noise given back", white),
        ("support", support, "Tables A1-A3: limits from the length", f"{captions.SUPPORT} {form}"),
    ):
        tables.write(folder / f"skurowski_{name}", rows, f"{PAPER}, {title}", caption)
    cleaning = gaussian_table.cleaning_of(of.settings.hampel.model_dump(mode="json"))
    fourth = gaussian_table.table_4(of.rows, of.gaussian, of.twins, cleaning)
    fourth = [row | {"note": appendix.note_of_table_4(row)} for row in fourth]
    shown = [{column: row[column] for column in appendix.TABLE_4_SHOWN} for row in fourth]
    caption = f"{appendix.TABLE_4_CAPTION} {sentence}"
    text = tables.markdown(shown, f"{PAPER}, Table 4: Gaussian model", caption)
    tables.write_with(folder / "skurowski_table4", fourth, text)
    yield f"Table 4: {len(fourth)} rows"
    for kind, number in coefficient_tables.TABLES.items():
        rows = of.coefficients[number]
        heading = f"{PAPER}, Table {number}: noise of {kind} cameras"
        caption = f"{appendix.CAPTION} {form}"
        text = appendix.table_a_markdown(rows, heading, caption, of.settings.duration_s)
        tables.write_with(folder / f"skurowski_table{number}", rows, text)
        yield f"Table {number}: {len(rows)} rows"
    yield counts


def pictures(of: Recordings) -> Iterator[tuple[int, Picture]]:
    """Figures 6 and 9-17 by number, one after the other."""
    yield 6, _regression(of)
    yield from _gaussian(of)
    allan = {name: read_table(of.file(name, "allan.parquet")) for name in of.rows}
    origin = next(iter(allan.values()))[1]
    columns = {name: table for name, (table, _) in allan.items()}
    cleaned, confidence = filter_sentence(origin), origin["allan"]["confidence"]
    largest = subsets.largest_sets(of.rows)
    yield 12, allan_figures.numbers_figure(of.rows, columns, *of.sources(remark=cleaned))
    texts = of.sources(list(largest.values()), cleaned)
    yield 13, allan_figures.types_figure(of.rows, columns, *texts, confidence)
    every = [row for rows in of.coefficients.values() for row in rows]
    sources = of.sources()
    yield 14, coefficients.colour_figure(every, *sources)
    yield 15, coefficients.colour_figure(every, *sources, logarithmic=False)
    yield 16, coefficients.correlated_figure(every, *sources)
    spectra, names = {}, {kind: largest[kind] for kind in subsets.TYPES if kind in largest}
    for kind, name in names.items():
        psd, _ = read_table(of.file(name, "psd.parquet"))
        pick = psd["series"] == SERIES
        label = f"{kind} ({subsets.TABLE_4[kind]})"
        spectra[label] = psd["f_hz"][pick], psd["psd_mm2_hz"][pick]
    yield 17, allan_figures.periodic_figure(spectra, *of.sources(list(names.values())))


def _regression(of: Recordings) -> Picture:
    """Figure 6, of all T40 cameras, or else of the first recording."""
    name = subsets.largest_sets(of.rows).get("T40") or next(iter(of.rows))
    columns, origin = read_table(of.file(name, "allan.parquet"))
    pick = (columns["series"] == SERIES) & (columns["estimator"] == "oadev")
    pick &= columns["avar_mm2"] > 0
    picked = {key: columns[key][pick] for key in ("m", "avar_mm2", "tau_s", "adev_mm")}
    rate, row = origin["frame_rate_hz"], of.rows[name]
    how = NoiseSettings.of(of.settings, rate, subset=(row["camera_type"], row["n_cameras"]))
    run, ordinary = regression(picked["m"], picked["avar_mm2"], rate, how, SERIES)
    remark = f"Series {SERIES} of recording {name}. {filter_sentence(origin)}"
    return allan_figures.regression_figure(
        *(
            (picked["tau_s"], picked["adev_mm"]),
            run.starts,
            ordinary.model,
            run.estimate.model,
            rate,
        ),
        of.sources([name], remark),
        form=how.noise.form,
    )


def _gaussian(of: Recordings) -> Iterator[tuple[int, Picture]]:
    """Figures 9-11."""
    lengths = {name: twin.duration_s for name, twin in of.twins.items()}
    source, remarks = tables.sources(of.rows, lengths)
    clean = {name: read_table(of.file(name, "clean.parquet"))[0] for name in of.densities}
    kinds = {name: of.rows[name]["camera_type"] for name in clean}
    first = next((name for name in clean if kinds[name] == "T40"), next(iter(clean)))
    x = {f"x{k}": clean[first][f"x{k}_mm"] for k in (1, 2)}
    printed = {k: published_gaussian(k) for k in kinds.values() if k in subsets.TABLE_4}
    source_9, of_first = tables.sources({first: of.rows[first]}, lengths)
    spread = _spread_sentence(of.twins.get(first))
    texts_9 = source_9, f"Recording {first}. {spread} {of_first}"
    yield 9, gaussian_figures.locations_figure(x, printed.get(kinds[first]), *texts_9)
    distances = {kinds[name]: table["L_mm"] for name, table in clean.items()}
    means = subsets.means_of_distance(of.rows, of.gaussian, of.twins)
    yield 10, gaussian_figures.distances_figure(distances, printed, means, source, remarks)
    spreads = subsets.spreads(of.rows, of.gaussian, of.twins)
    texts = captions.of_figure("skurowski", 11, source, remarks)
    yield 11, gaussian_figures.scaling_figure(spreads, texts, variances=True)
