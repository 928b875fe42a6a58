"""Files that a sheet names by their place in S3: `s3://bucket/key`.

Snakemake's storage plugin retrieves them. It is no part of the environment of every user.
"""

from __future__ import annotations

import importlib.util
import re

from mocap_metrology.common.faults import Unfit

S3 = "s3://"
OBJECT = re.compile(r"s3://[A-Za-z0-9][A-Za-z0-9._-]{1,61}[A-Za-z0-9](/[^/<>{}]+)+")
PLUGIN = "snakemake_storage_plugin_s3"


def in_s3(path: str) -> bool:
    return path.startswith(S3)


def checked(path: str) -> str:
    """The path, refused where it names no object or where nothing could retrieve it. Whether the
    object exists is for Snakemake to see."""
    parts = path.split("/")
    if not OBJECT.fullmatch(path) or "." in parts or ".." in parts:
        raise Unfit("s3://bucket/key without any of < > { }", path)
    if importlib.util.find_spec(PLUGIN) is None:
        raise Unfit("a file of this computer, or the plugin that reads S3 (`make s3`)", path)
    return path
