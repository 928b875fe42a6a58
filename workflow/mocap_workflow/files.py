"""The file of twins, and where it and the sheets are found."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import yaml

from mocap_workflow.faults import Faults, shown, unknown

YAML = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # every job reads the twins: 0.05 s or 0.4 s
TwinsFile = dict[str, dict[str, Any]]  # its sections
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")


def found(value: str | None, root: Path) -> str | None:
    """A relative path of the configuration: in the working folder, else in the project's."""
    if value is None or Path(value).exists() or not (root / value).exists():
        return value
    return str(root / value)


def load_twins(path: str | None) -> TwinsFile:
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
