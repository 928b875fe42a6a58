"""`make env` behind a proxy that inspects TLS: its certificate is in the system's store alone."""

import http.server
import os
import shutil
import ssl
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

STORE = Path("/etc/ssl/certs")  # of Linux
CA = "openssl req -x509 -newkey rsa:2048 -nodes -keyout ca.key -out ca.pem -subj /CN=proxy -days 2"
KEY = "openssl req -newkey rsa:2048 -nodes -keyout key.pem -out key.csr -subj /CN=localhost"
SIGN = (
    "openssl x509 -req -in key.csr -CA ca.pem -CAkey ca.key -CAcreateserial -out cert.pem -days 2"
)
SIGN += " -extfile names"
PROBES = {
    "uv": "echo toy | $(CLEAN) {bin}/uv pip compile --quiet --no-cache --index-url {url} -",
    "pip": "$(CLEAN) {bin}/python -m pip download -q --retries 0 --index-url {url} -d {folder} toy",
}


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, str, list[str]]]:
    """Folder that stands for the system's store; address of an index; paths that are requested."""
    if shutil.which("openssl") is None or not STORE.is_dir():
        pytest.skip(f"no openssl, or no {STORE}")
    if subprocess.run(["unshare", "-m", "true"], capture_output=True).returncode:
        pytest.skip("no right to mount")
    folder, seen = tmp_path_factory.mktemp("tls"), []
    (folder / "names").write_text("subjectAltName=DNS:localhost\n")
    for command in (CA, KEY, SIGN):
        subprocess.run(command.split(), cwd=folder, check=True, capture_output=True)
    (folder / "store").mkdir()
    shutil.copy(folder / "ca.pem", folder / "store/ca-certificates.crt")

    class Index(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            seen.append(self.path)
            self.send_error(404)

        def log_message(self, *_: object) -> None:
            pass

    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(folder / "cert.pem", folder / "key.pem")
    with http.server.ThreadingHTTPServer(("localhost", 0), Index) as listening:
        listening.socket = context.wrap_socket(listening.socket, server_side=True)
        threading.Thread(target=listening.serve_forever, daemon=True).start()
        yield folder / "store", f"https://localhost:{listening.server_port}/simple", seen
        listening.shutdown()


@pytest.mark.parametrize("program", PROBES)
def test_the_certificates_of_the_system_are_those_of_make_env(
    server: tuple[Path, str, list[str]], tmp_path: Path, root: Path, program: str
) -> None:
    store, url, seen = server
    seen.clear()
    where = {"bin": Path(sys.executable).parent, "url": url, "folder": tmp_path}
    rule = f"probe: ; {PROBES[program].format(**where)}"
    words = ("CERT", "SSL", "CA_BUNDLE", "PROXY", "MAKE", "PIP_", "UV_")
    plain = {k: v for k, v in os.environ.items() if not any(w in k.upper() for w in words)}
    command = f'mount --bind {store} {STORE} && exec make --eval "$RULE" probe'
    done = subprocess.run(
        ["unshare", "-m", "sh", "-c", command],
        **{"cwd": root, "env": plain | {"RULE": rule}, "check": False},
        **{"capture_output": True, "text": True, "timeout": 120},
    )
    assert seen and set(seen) == {"/simple/toy/"}, done.stderr
