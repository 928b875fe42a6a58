"""compare_results.py finds every number that differs, and nothing else."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.compare_results import main
from mocap_metrology.common.files import write_table

TABLE = "series,value,unit\nx1,1.2345e-05,mm\nL,,mm\n"


def write(folder: Path, text: str = TABLE, column: tuple[float, ...] = (1.0, np.nan, 3.0)) -> Path:
    (folder / "recordings/A").mkdir(parents=True)
    (folder / "recordings/A/noise.csv").write_text(text, encoding="utf-8")
    write_table(
        folder / "recordings/A/allan.parquet",
        {"adev_mm": np.array(column)},
        {"seed": 1, "versions": {"numpy": folder.name}},
    )
    (folder / "logs").mkdir()
    (folder / "logs/run.md").write_text(f"took {folder.name}", encoding="utf-8")
    return folder


def compared(tmp_path: Path, *options: str, **after: object) -> int:
    write(tmp_path / "1")
    write(tmp_path / "2", **after)  # type: ignore[arg-type]
    return main([str(tmp_path / "1"), str(tmp_path / "2"), *options])


def test_equal_folders_but_for_logs_and_versions(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert compared(tmp_path) == 0
    assert "2 files compared, 2 equal" in capsys.readouterr().out


@pytest.mark.parametrize(
    "after",
    [{"text": TABLE.replace("1.2345e-05", "1.23450001e-05")},
     {"text": TABLE.replace("L,,mm", "L,0,mm")}, {"text": TABLE.replace("mm\nL", "m\nL")},
     {"text": TABLE + "z2,1,mm\n"}, {"column": (1.0, 2.0, 3.0)}, {"column": (1.0, np.nan)},
     {"column": (1.0, np.nan, 3.0 + 1e-9)}],
    ids=["digit", "gap filled", "unit", "row", "NaN", "length", "Parquet digit"],
)  # fmt: skip
def test_whatever_differs_is_found(tmp_path: Path, after: dict[str, object]) -> None:
    assert compared(tmp_path, "--relative", "1e-12", **after) == 1


def test_a_folder_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SystemExit):
        main([str(tmp_path), str(tmp_path / "absent")])
