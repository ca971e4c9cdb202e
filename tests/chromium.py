# SPDX-License-Identifier: GPL-2.0-or-later
"""Headless Chromium, driven through its pipe by the DevTools protocol: no other program or package is needed."""

from __future__ import annotations

import base64
import fcntl
import json
import os
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PROGRAM = shutil.which("chromium")
FLAGS = (
    "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --hide-scrollbars --remote-debugging-pipe"
)
OWN = ("file:", "data:", "blob:")
WRONG = {"error", "assert", "warning"}


class Chromium:
    """One browser; messages are JSON with a zero byte behind each, on the file descriptors 3 and 4 of the child."""

    def __init__(self, profile: Path):
        (reads, self.to_child), (self.from_child, writes) = os.pipe(), os.pipe()
        ends = [fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (reads, writes)]  # out of the way of 3 and 4
        script = f"exec {PROGRAM} {FLAGS} --user-data-dir='{profile}' about:blank 3<&{ends[0]} 4>&{ends[1]}"
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self.process = subprocess.Popen(["bash", "-c", script], pass_fds=ends, **quiet)
        for end in (reads, writes, *ends):
            os.close(end)
        self.stream = os.fdopen(self.from_child, "rb")
        self.count, self.rest, self.events = 0, b"", []

    def call(self, method: str, session: str | None = None, **parameters) -> dict:
        """Ask for something and wait for the answer; events on the way are kept."""
        self.count += 1
        message = {"id": self.count, "method": method, "params": parameters}
        os.write(self.to_child, json.dumps(message | ({"sessionId": session} if session else {})).encode() + b"\0")
        while True:
            found = self.next()
            if found.get("id") == self.count:
                if "error" in found:
                    raise RuntimeError(f"{method}: {found['error']['message']}")
                return found["result"]
            self.events.append(found)

    def next(self) -> dict:
        """The next message of the browser."""
        while b"\0" not in self.rest:
            part = self.stream.read1(1 << 20)
            if not part:
                raise RuntimeError("Chromium ended")
            self.rest += part
        message, _, self.rest = self.rest.partition(b"\0")
        return json.loads(message)

    def close(self) -> None:
        """End the browser."""
        self.call("Browser.close")
        self.process.wait()
        self.stream.close()
        os.close(self.to_child)


class Address:
    """An address that a `Page` opens in place of a file."""

    def __init__(self, text: str):
        self.text = text

    def absolute(self) -> Address:
        """Itself, as a path has it."""
        return self

    def as_uri(self) -> str:
        """The address."""
        return self.text


class Page:
    """A tab with one file open in it."""

    def __init__(self, browser: Chromium, path: Path | Address, *, width=1280, height=1000, scale=1.0, dark=False,
                 phone=False, still=True, scripts=True):  # fmt: skip
        self.browser = browser
        target = browser.call("Target.createTarget", url="about:blank")["targetId"]
        self.target = target
        self.session = browser.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        self.call(
            "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=scale, mobile=phone
        )
        features = {"prefers-color-scheme": "dark" if dark else "light"}
        features["prefers-reduced-motion"] = "reduce" if still else "no-preference"
        self.call("Emulation.setEmulatedMedia", features=[{"name": k, "value": v} for k, v in features.items()])
        if phone:
            self.call("Emulation.setTouchEmulationEnabled", enabled=True)
        if not scripts:
            self.call("Emulation.setScriptExecutionDisabled", value=True)
        self.call("Page.navigate", url=path.absolute().as_uri())
        self.wait_for("Page.loadEventFired")

    def call(self, method: str, **parameters) -> dict:
        """Ask this tab for something."""
        return self.browser.call(method, self.session, **parameters)

    def wait_for(self, event: str) -> None:
        """Wait for an event of this tab."""
        while not any((found.get("method"), found.get("sessionId")) == (event, self.session) for found in self.events):
            self.browser.events.append(self.browser.next())

    @property
    def events(self) -> list[dict]:
        """What the tab told on its own."""
        return [found for found in self.browser.events if found.get("sessionId") == self.session]

    def run(self, script: str) -> object:
        """The value of an expression, waited for where it is a promise."""
        answer = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"]["exception"].get("description", str(answer)))
        return answer["result"].get("value")

    def troubles(self) -> list[str]:
        """Errors, warnings, and requests for anything but the file itself and data inside it."""
        self.run("0")  # what was told before is here now
        found = []
        for event in self.events:
            name, told = event["method"], event["params"]
            if name == "Runtime.exceptionThrown":
                found.append(str(told["exceptionDetails"]))
            elif name == "Log.entryAdded" and told["entry"]["level"] in WRONG:
                found.append(told["entry"]["text"])
            elif name == "Runtime.consoleAPICalled" and told["type"] in WRONG:
                found.append(str(told["args"]))
            elif name == "Network.requestWillBeSent" and not told["request"]["url"].startswith(
                ("file:", "data:", "blob:")
            ):
                found.append(f"asks for {told['request']['url']}")
        return found

    def picture(self, path: Path, *, whole: bool = False) -> Path:
        """A screenshot, of the whole page or of what is seen."""
        data = self.call("Page.captureScreenshot", captureBeyondViewport=whole)["data"]
        path.write_bytes(base64.b64decode(data))
        return path

    def close(self) -> None:
        """Close the tab."""
        self.browser.call("Target.closeTarget", targetId=self.target)


@contextmanager
def chromium(profile: Path) -> Iterator[Chromium]:
    """A browser with a profile folder of its own."""
    browser = Chromium(profile)
    try:
        yield browser
    finally:
        browser.close()
