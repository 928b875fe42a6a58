"""Tables 3, 4 and A1-A3 and Figures 6 and 9-17 of S, from the results of the recordings of its
group."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from mocap_metrology.common.files import Metadata, read_metadata, read_table
from mocap_metrology.noise.fit.estimates import NoiseRow, read_noise
from mocap_metrology.noise.fit.estimators import NoiseSettings, regression
from mocap_metrology.noise.twins.published import published_gaussian
from mocap_metrology.noise.twins.twin import Twin
from mocap_metrology.present import tables
from mocap_metrology.present.plot.figure import Picture
from mocap_metrology.present.skurowski import (
    allan_families,
    appendix,
    appendix_text,
    camera_tables,
    coefficients,
    densities,
    gather,
    gaussian_table,
    scaling,
    series_figures,
)
from mocap_metrology.present.tables import Record, Row
from mocap_metrology.present.text import captions
from mocap_metrology.settings import Settings

Table = tuple[Sequence[Row], str]  # rows and Markdown of a table


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
    def tables_a(self) -> dict[str, list[Row]]:
        """Rows of Tables A1-A3."""
        noise = {name: self._noise(name, "noise.csv") for name in self.rows}
        expected = {name: self._noise(name, "expected.csv") for name in self.expected}
        return appendix.tables_a(self.rows, noise, expected)

    def _noise(self, recording: str, name: str) -> list[NoiseRow]:
        return read_noise(self.file(recording, name))

    def gaussian(self, axis: str) -> dict[str, Row]:
        """The row of gaussian.csv of each recording, of that axis where it has one."""
        found = {}
        for name in self.rows:
            rows: Any = tables.read(self.file(name, "gaussian.csv")).to_dict("records")
            found[name] = gather.gaussian_row(rows, axis)
        return found

    @cached_property
    def lengths_s(self) -> dict[str, float]:
        paths = {name: self.file(name, "allan.parquet") for name in self.rows}
        return {name: gather.length_s(read_metadata(path)) for name, path in paths.items()}

    def sources(self, names: Sequence[str] = ()) -> tuple[str, str]:
        """Line at the foot of a figure of some of the recordings, or of all, and a remark."""
        shown = {name: self.rows[name] for name in names or self.rows}
        return gather.sources(shown, self.lengths_s)


def write_tables(of: Recordings, folder: Path) -> Iterator[str]:
    """Write Tables 3, 4, A1-A3 and two that sum the last ones up; yields a line on each."""
    sources = {name: tables.source_of(row) for name, row in of.rows.items()}
    sentence = tables.source_sentence(sources, of.settings.duration_s)
    form = f"{sentence} {appendix.FORM_WORDS[of.settings.twin_form]}"
    every = [row for rows in of.tables_a.values() for row in rows]
    levels = appendix_text.white_levels(every)
    title = f"{captions.PAPER}, Tables A1-A3:"
    for name, rows, heading, caption in (
        (
            "table3",
            camera_tables.table_3(of.rows),
            f"{captions.PAPER}, Table 3: camera subsets",
            f"{camera_tables.TABLE_3_CAPTION} {sentence}",
        ),
        (
            "white_levels",
            levels,
            f"{title} white noise given back",
            f"{appendix_text.summary(levels)} {appendix_text.CAPTION} {form}",
        ),
        (
            "support",
            appendix.support_counts(every),
            f"{title} limits from the length",
            f"{appendix.SUPPORT} {form}",
        ),
    ):
        tables.write(folder / f"skurowski_{name}", rows, heading, caption)
    for number, (table, text) in {"4": _table_4(of, sentence), **_tables_a(of, form)}.items():
        tables.write_with(folder / f"skurowski_table{number}", table, text)
        yield f"Table {number}: {len(table)} rows"
    yield appendix_text.summary(levels)


def _table_4(of: Recordings, sentence: str) -> Table:
    """Every published number beside the regenerated one, with the band of chance."""
    cleaning = gaussian_table.cleaning_of(of.settings.hampel.model_dump(mode="json"))
    gaussian = camera_tables.table_4(of.rows, of.gaussian("x"))
    rows = gaussian_table.with_chance(gaussian, of.twins, cleaning)
    short = [{column: row[column] for column in gaussian_table.SHOWN} for row in rows]
    caption = f"{gaussian_table.CAPTION} {camera_tables.TABLE_4_CAPTION} {sentence}"
    return rows, tables.markdown(short, f"{captions.PAPER}, Table 4: Gaussian model", caption)


def _tables_a(of: Recordings, sentence: str) -> dict[str, Table]:
    """Tables A1-A3, by number."""
    found: dict[str, Table] = {}
    for number, rows in of.tables_a.items():
        kind = rows[0]["camera_type"]
        title = f"{captions.PAPER}, Table {number}: noise of {kind} cameras"
        caption = f"{appendix.CAPTION} {sentence}"
        length = of.settings.duration_s
        found[number] = rows, appendix_text.table_a_markdown(rows, title, caption, length)
    return found


def pictures(of: Recordings) -> Iterator[tuple[int, Picture]]:
    """Figures 6 and 9-17 by number, one after the other."""
    yield 6, _regression(of)
    yield from _densities(of)
    allan = {name: read_table(of.file(name, "allan.parquet")) for name in of.rows}
    origin = next(iter(allan.values()))[1]
    columns = {name: table for name, (table, _) in allan.items()}

    def texts(names: Sequence[str]) -> tuple[str, str]:
        source, remarks = of.sources(names)
        return source, f"{gather.filter_sentence(origin)} {remarks}".strip()

    types = list(allan_families.types_of(of.rows).values())
    confidence = origin["allan"]["confidence"]
    yield 12, allan_families.numbers_figure(of.rows, columns, *texts(list(of.rows)))
    yield 13, allan_families.types_figure(of.rows, columns, *texts(types), confidence)
    every = [row for rows in of.tables_a.values() for row in rows]
    titles, sources = gather.TITLES, of.sources()
    yield 14, coefficients.colour_figure(every, titles[14], *sources)
    yield 15, coefficients.colour_figure(every, titles[15], *sources, logarithmic=False)
    yield 16, coefficients.correlated_figure(every, titles[16], *sources)
    yield 17, _periodic(of)


def _regression(of: Recordings) -> Picture:
    """Figure 6."""
    name = gather.of_regression(of.rows)
    columns, origin = read_table(of.file(name, "allan.parquet"))
    of_series = (columns["series"] == gather.SERIES) & (columns["estimator"] == "oadev")
    pick = of_series & (columns["avar_mm2"] > 0)
    rate, row = origin["frame_rate_hz"], of.rows[name]
    subset = row["camera_type"], row["n_cameras"]
    how = NoiseSettings.of(of.settings, rate, subset=subset)
    run, ordinary = regression(
        columns["m"][pick], columns["avar_mm2"][pick], rate, how, gather.SERIES
    )
    return series_figures.regression_figure(
        (columns["tau_s"][pick], columns["adev_mm"][pick]),
        run.starts,
        ordinary.model,
        run.estimate.model,
        rate,
        _texts_6(of, name, origin),
        form=how.form,
    )


def _texts_6(of: Recordings, name: str, origin: Metadata) -> tuple[str, str, str]:
    source, twins = of.sources([name])
    what = f"Series {gather.SERIES} of recording {name}."
    return gather.TITLES[6], source, f"{what} {gather.filter_sentence(origin)} {twins}"


def _densities(of: Recordings) -> Iterator[tuple[int, Picture]]:
    """Figures 9-11."""
    lengths = {name: twin.duration_s for name, twin in of.twins.items()}
    source, remarks = gather.sources(of.rows, lengths)
    gaussian = of.gaussian("x")
    clean = {name: read_table(of.file(name, "clean.parquet"))[0] for name in of.densities}
    kinds = {name: of.rows[name]["camera_type"] for name in clean}
    first = gather.of_locations(of.rows, list(clean))
    x = {f"x{k}": clean[first][f"x{k}_mm"] for k in (1, 2)}
    printed = {k: published_gaussian(k) for k in kinds.values() if k in camera_tables.TABLE_4}
    source_9, of_first = gather.sources({first: of.rows[first]}, lengths)
    spread = gather.spread_sentence(of.twins.get(first))
    remarks_9 = f"Recording {first}. {spread} {of_first}"
    yield 9, densities.locations_figure(x, printed.get(kinds[first]), source_9, remarks_9)
    distances: dict[str, np.ndarray] = {kinds[k]: table["L_mm"] for k, table in clean.items()}
    means = gather.means(of.rows, gaussian, of.twins)
    yield 10, densities.distances_figure(distances, printed, means, source, remarks)
    texts = scaling.TITLE_11, source, f"{captions.SKUROWSKI[11]} {remarks}"
    subsets = gather.subsets(of.rows, gaussian, of.twins)
    yield 11, scaling.scaling_figure(subsets, texts, variances=True)


def _periodic(of: Recordings) -> Picture:
    """Figure 17."""
    spectra = {}
    for label, name in gather.largest(of.rows).items():
        psd, _ = read_table(of.file(name, "psd.parquet"))
        pick = psd["series"] == gather.SERIES
        spectra[label] = psd["f_hz"][pick], psd["psd_mm2_hz"][pick]
    texts = of.sources(list(gather.largest(of.rows).values()))
    return series_figures.periodic_figure(spectra, gather.LINE_HZ, gather.TITLES[17], *texts)
