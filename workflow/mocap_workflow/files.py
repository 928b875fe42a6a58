"""Files that a sheet names: relative to the sheet, or made by a twin."""

from __future__ import annotations

import os
import re
from collections.abc import Collection
from pathlib import Path
from typing import Any

import yaml

from mocap_workflow.faults import Faults, shown, unknown
from mocap_workflow.tsv import Row

YAML = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # every job reads the twins: 0.05 s or 0.4 s
SIMULATE = "simulate:"
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")


def found(value: str | None, root: Path) -> str | None:
    """A relative path of the configuration: in the working folder, else in the project's."""
    if value is None or Path(value).exists() or not (root / value).exists():
        return value
    return str(root / value)


def beside(sheet: str, path: str) -> str:
    """`path` as seen from the working folder, relative ones being relative to the sheet."""
    return os.path.normpath(Path(sheet).parent / path)


def check_file(row: Row, column: str, path: str, any_kind: bool = False) -> str:
    """The path beside the sheet; blame one that is no file or that Snakemake cannot name.

    `any_kind` leaves what is there but no file to the rule that reads it.
    """
    here = beside(row.sheet, path)
    if set("<>{}") & set(here):
        row.blame(column, "a path without any of < > { }", path)
    elif not Path(here).exists():
        row.blame(column, f"a file ({here} does not exist)", path)
    elif not (any_kind or Path(here).is_file()):
        row.blame(column, f"a file ({here} is something else)", path)
    return here


def check_twin(row: Row, column: str, twins: Collection[str]) -> str | None:
    """The twin that the cell names, None if it names files; blame one that is not known."""
    if not row[column].startswith(SIMULATE):
        return None
    twin = row[column].removeprefix(SIMULATE).strip()
    if twin not in twins:
        row.blame(column, f"simulate: and a twin of the file of twins ({unknown(twin, twins)})")
    return twin


def load_twins(path: str | None) -> dict[str, dict[str, Any]]:
    """The file of twins: `twins` by name, `defaults` by kind, `setups` and `factories` by name.
    What they hold is for those who make them to judge."""
    sections = ("defaults", "factories", "setups", "twins")
    if path is None:
        return {section: {} for section in sections}
    try:
        content = yaml.load(Path(path).read_text(encoding="utf-8"), YAML)
    except FileNotFoundError:
        raise Faults([f"{path}: no such file; expected the file of twins"]) from None
    except (OSError, UnicodeDecodeError) as error:
        raise Faults([f"{path}: {error}; expected the file of twins"]) from None
    except yaml.YAMLError as error:
        raise Faults([f"{path}: not YAML ({error})"]) from None
    if not isinstance(content, dict) or not isinstance(content.get("twins"), dict):
        raise Faults([f"{path}: no section twins; expected twins: with a name for each"])
    faults = [
        f"{path}, section {key}: {unknown(key, sections)}" for key in content.keys() - {*sections}
    ]
    content = {section: content.get(section) or {} for section in sections}
    for section, entries in content.items():
        faults += [
            f'{path}, {section}, {shown(str(name))}: expected a name of letters, digits, "_", "."'
            f' and "-", and a section of settings'
            for name, settings in (entries or {}).items()
            if not (NAME.fullmatch(str(name)) and isinstance(settings, dict))
        ]
    if faults:
        raise Faults(faults)
    return content
