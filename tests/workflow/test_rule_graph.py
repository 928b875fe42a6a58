"""The rule graph of the pages is what Snakemake draws."""

import subprocess
import sys
from xml.etree import ElementTree

from running import environment


def test_the_page_shows_the_rules_there_are(root, tmp_path) -> None:
    command = [sys.executable, str(root / "workflow/rule_graph.py"), "--check"]
    done = subprocess.run(command, cwd=tmp_path, env=environment(), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert not list(tmp_path.iterdir())
    picture = ElementTree.parse(root / "docs/rule_graph.svg").getroot()
    words = {text.text for text in picture.iter("{http://www.w3.org/2000/svg}text")}
    assert {"clean_twin", "noise", "skurowski"} <= words
