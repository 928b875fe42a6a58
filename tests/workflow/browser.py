"""A headless Chromium spoken to over its DevTools pipe: what a page asks for, logs and shows."""

import contextlib
import json
import os
import select
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
OPTIONS = (
    "--headless=new",
    "--no-sandbox",  # CI runs as root
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--remote-debugging-pipe",
)
# The protocol wants descriptors 3 and 4.
START = """
import os, sys
ends = [os.dup(os.dup(os.dup(int(end)))) for end in sys.argv[1:3]]
os.dup2(ends[0], 3)
os.dup2(ends[1], 4)
os.execvp(sys.argv[3], sys.argv[3:])
"""
DOMAINS = ("Page", "Runtime", "Log", "Network")
PATIENCE_S = 300  # seconds do, unless other work has the cores

# Of the report that Snakemake writes, in JavaScript; where there is a %s, of a result's path
READY = "document.querySelector('#app')?.innerText"
SHOW = """(() => {
  const result = results[%s];
  const content = result.mime_type === "text/html" ? "html" : "img";
  document.addEventListener("load", event => { window.loaded = event.target.src; }, true);
  app.setView({content, contentPath: result.data_uri, resultPath: %s});
})()"""
SHOWN = """(() => {
  const result = results[%s];
  const html = result.mime_type === "text/html";
  const shown = document.querySelector(html ? "iframe" : "#app div.p-3 > img");
  const there = html ? window.loaded === result.data_uri : shown?.naturalWidth > 0;
  return shown?.src === result.data_uri && there;
})()"""
# Left and top edge of the title in its page, as scrolled to the top, and its width
TITLE = """(() => {
  const title = document.querySelector(".prose h1"), page = title.closest(".overflow-auto");
  page.scrollTo(0, 0);
  const {left, top, right} = title.getBoundingClientRect();
  return [left - page.getBoundingClientRect().left, top, right - left];
})()"""
ACTIVE_LINKS = """[...document.querySelectorAll("a, iframe, object, embed")].filter(element =>
  /^(javascript|http)/.test(element.href || element.src || element.data)).length"""
LINKS = "[...document.querySelectorAll('.mm a')].map(a => [a.textContent, a.getAttribute('href')])"


class Browser:
    """One page; `requests`, `errors` and `dialogs` grow while it lives, those of its frames
    included."""

    def __init__(self, send: int, receive: int):
        self.send, self.receive, self.buffer, self.number = send, receive, b"", 0
        self.requests: list[str] = []
        self.errors: list[str] = []
        self.dialogs: list[str] = []
        target = self.call("Target.createTarget", {"url": "about:blank"})["targetId"]
        self.session = self.call("Target.attachToTarget", {"targetId": target, "flatten": True})[
            "sessionId"
        ]
        self._listen(self.session)

    def _listen(self, session: str) -> None:
        for domain in DOMAINS:
            self.call(f"{domain}.enable", session=session)
        attach = {"autoAttach": True, "waitForDebuggerOnStart": False, "flatten": True}
        self.call("Target.setAutoAttach", attach, session)

    def call(self, method: str, params: dict | None = None, session: str | None = None) -> dict:
        """The result of a method of the protocol."""
        self.number += 1
        number = self.number
        message = {"id": number, "method": method, "params": params or {}}
        if session:
            message["sessionId"] = session
        os.write(self.send, json.dumps(message).encode() + b"\0")
        until = time.monotonic() + PATIENCE_S
        while True:
            answer = self._next(until - time.monotonic())
            if answer is None:
                raise TimeoutError(method)
            if answer.get("id") == number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self._note(answer)

    def _next(self, seconds: float) -> dict | None:
        until = time.monotonic() + seconds
        while b"\0" not in self.buffer:
            left = until - time.monotonic()
            if left <= 0 or not select.select([self.receive], [], [], left)[0]:
                return None
            data = os.read(self.receive, 1 << 20)
            if not data:
                raise EOFError("the browser is gone")
            self.buffer += data
        message, _, self.buffer = self.buffer.partition(b"\0")
        return json.loads(message)

    def _note(self, event: dict) -> None:
        kind, params = event.get("method"), event.get("params", {})
        if kind == "Network.requestWillBeSent":
            self.requests.append(params["request"]["url"])
        elif kind == "Page.javascriptDialogOpening":
            self.dialogs.append(params["message"])
            self.call("Page.handleJavaScriptDialog", {"accept": True}, self.session)
        elif kind == "Runtime.exceptionThrown":
            details = params["exceptionDetails"]
            self.errors.append(details.get("exception", {}).get("description") or details["text"])
        elif kind == "Runtime.consoleAPICalled" and params["type"] in ("error", "assert"):
            self.errors.append(" ".join(str(a.get("value", a)) for a in params["args"]))
        elif kind == "Log.entryAdded" and params["entry"]["level"] == "error":
            self.errors.append(f"{params['entry']['text']} ({params['entry'].get('url', '')})")
        elif kind == "Target.attachedToTarget" and params["targetInfo"]["type"] == "iframe":
            self._listen(params["sessionId"])

    def until(self, expression: str, seconds: float = PATIENCE_S) -> Any:
        """The value of an expression once it is true; until then it may fail, as it does while a
        page is loaded. `TimeoutError` where it never is."""
        end = time.monotonic() + seconds
        while True:
            try:
                found = self.evaluate(expression)
            except RuntimeError as error:
                found, why = None, str(error)
            else:
                why = repr(found)
            if found:
                return found
            if time.monotonic() > end:
                raise TimeoutError(f"{expression}: {why} after {seconds:g} s")
            time.sleep(0.02)

    def open(self, url: str, ready: str) -> None:
        """Go there, and wait until an expression of the new page is true."""
        self.evaluate("window.left = true")  # it goes with the old page
        self.call("Page.navigate", {"url": url}, self.session)
        self.until(f"!window.left && document.readyState === 'complete' && !!({ready})")

    def evaluate(self, expression: str) -> Any:
        """The value of an expression of JavaScript in the page."""
        params = {"expression": expression, "returnByValue": True, "awaitPromise": True}
        found = self.call("Runtime.evaluate", params, self.session)
        if "exceptionDetails" in found:
            raise RuntimeError(str(found["exceptionDetails"]))
        return found["result"].get("value")

    def size(self, width: int, height: int) -> None:
        """Size of the window, in CSS pixels."""
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.call("Emulation.setDeviceMetricsOverride", metrics, self.session)


@contextlib.contextmanager
def browser(executable: str, profile: Path) -> Iterator[Browser]:
    """A browser with a profile folder of its own; it is ended at the end."""
    (their_in, our_out), (our_in, their_out) = os.pipe(), os.pipe()
    ends = (str(their_in), str(their_out))
    process = subprocess.Popen(
        [sys.executable, "-c", START, *ends, executable, *OPTIONS, f"--user-data-dir={profile}"],
        pass_fds=(their_in, their_out),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(their_in)
    os.close(their_out)
    try:
        yield Browser(our_out, our_in)
    finally:
        process.terminate()
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        os.close(our_out)
        os.close(our_in)
