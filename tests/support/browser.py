"""Chromium, driven over a pipe: nothing but Python is needed. Tests of pages use it."""

import base64
import json
import os
import select
import shutil
import subprocess
import time

PATIENCE_S = 300  # machines may be busy; nothing here waits that long but on an error


def chromium():
    """The path of a Chromium, or None."""
    return next((path for name in ("chromium", "chromium-headless-shell", "google-chrome") if (path := shutil.which(name))), None)


class Browser:
    """A headless Chromium. @param home  a folder for its profile and its log"""

    def __init__(self, binary, home):
        to_browser, self._write = os.pipe()
        self._read, from_browser = os.pipe()

        def as_three_and_four():
            # The ends may be 3 or 4 themselves: out of the way first.
            a, b = os.dup(to_browser), os.dup(from_browser)
            a, b = (os.dup(a) if a in (3, 4) else a), (os.dup(b) if b in (3, 4) else b)
            os.dup2(a, 3)
            os.dup2(b, 4)

        arguments = [
            binary,
            "--headless=new",
            "--remote-debugging-pipe",
            "--disable-gpu",
            "--disable-dev-shm-usage",
            "--no-first-run",
            "--no-default-browser-check",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-extensions",
            "--hide-scrollbars",
            "--user-data-dir=" + os.path.join(home, "profile"),
            "about:blank",
        ]
        if os.geteuid() == 0:
            arguments.insert(1, "--no-sandbox")
        self._log = open(os.path.join(home, "chromium.log"), "wb")
        self._process = subprocess.Popen(
            arguments,
            preexec_fn=as_three_and_four,
            close_fds=False,
            stdin=subprocess.DEVNULL,
            stdout=self._log,
            stderr=self._log,
            env=dict(os.environ, HOME=home),
        )
        os.close(to_browser)
        os.close(from_browser)
        self._buffer = b""
        self._number = 0
        self.events = []
        self.left = set()  # sessions whose console no longer counts

    def _message(self):
        end = time.monotonic() + PATIENCE_S
        while b"\0" not in self._buffer:
            ready, _, _ = select.select([self._read], [], [], max(0, end - time.monotonic()))
            part = os.read(self._read, 1 << 20) if ready else b""
            if not part:
                raise RuntimeError("chromium ended or is silent; chromium.log has its messages")
            self._buffer += part
        message, self._buffer = self._buffer.split(b"\0", 1)
        return json.loads(message)

    def ask(self, method, session=None, **parameters):
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self._write, data) :]
        while True:
            answer = self._message()
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self.events.append(answer)

    def open(self, width, dark, height=900):
        """A new tab as (target, session), with its console and its requests noted in `events`."""
        self.events = []
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.ask(domain + ".enable", session)
        self.resize(session, width, height)
        self.ask("Emulation.setEmulatedMedia", session, features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])
        return target, session

    def resize(self, session, width, height=900):
        """Below 600 px the screen is a telephone's."""
        narrow = width < 600
        self.ask(
            "Emulation.setDeviceMetricsOverride", session, width=width, height=height, deviceScaleFactor=2 if narrow else 1, mobile=narrow
        )

    def evaluate(self, session, expression):
        """The value of a JavaScript expression, or of its promise."""
        answer = self.ask("Runtime.evaluate", session, expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(
                f"{expression[:200]}: {answer['exceptionDetails'].get('exception', {}).get('description', answer['exceptionDetails'])}"
            )
        return answer["result"].get("value")

    def screenshot(self, session, picture, **more):
        shot = self.ask("Page.captureScreenshot", session, **({"format": "png"} | more))
        with open(picture, "wb") as file:
            file.write(base64.b64decode(shot["data"]))

    def complaints(self):
        """What the console of the tabs showed since `events` was emptied: errors, warnings, broken policies."""
        return [
            json.dumps(e["params"])[:600]
            for e in self.events
            if e.get("sessionId") not in self.left
            and e.get("method") in ("Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded")
        ]

    def wait_for(self, method, session):
        while True:
            for event in self.events:
                if event.get("method") == method and event.get("sessionId") == session:
                    return
            self.events.append(self._message())

    def close(self):
        try:
            self.ask("Browser.close")
            self._process.wait(60)
        except Exception:
            self._process.kill()
            self._process.wait()
        self._log.close()


ALT, CTRL, SHIFT = 1, 2, 8
KEY_CODES = {"Enter": 13, "Escape": 27, " ": 32, "ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40, "Tab": 9, "Delete": 46}


class Tab:
    """One page of a browser, used as a person uses it: with keys and a mouse, looking at what is there."""

    def __init__(self, browser, width=1280, dark=False, height=900):
        self.browser = browser
        self.target, self.session = browser.open(width, dark, height)

    def go(self, url):
        self.browser.ask("Page.navigate", self.session, url=url)

    def reload(self):
        self.browser.ask("Page.reload", self.session)

    def js(self, expression):
        return self.browser.evaluate(self.session, expression)

    def wait(self, expression, words):
        """Waits until a JavaScript expression is true, and returns its value."""
        end = time.monotonic() + PATIENCE_S
        while True:
            try:
                value = self.js(expression)
            except RuntimeError:
                value = None  # the page is just being loaded
            if value or value == {}:  # an element
                return value
            if time.monotonic() > end:
                raise AssertionError(f"{words}: never so; the page has: {self.js('document.body.innerText')[:2000]}")
            time.sleep(0.05)

    def text(self, selector):
        return self.js(f"document.querySelector({json.dumps(selector)})?.textContent ?? null")

    def box(self, selector):
        """(left, top, width, height) on the screen, scrolled to."""
        return self.js(
            f"(() => {{ const e = document.querySelector({json.dumps(selector)}); e.scrollIntoView({{block: 'nearest'}});"
            " const b = e.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()"
        )

    def mouse(self, kind, x, y, modifiers=0, **more):
        self.browser.ask("Input.dispatchMouseEvent", self.session, type=kind, x=x, y=y, modifiers=modifiers, **more)

    def click_at(self, x, y):
        self.mouse("mouseMoved", x, y)
        self.mouse("mousePressed", x, y, button="left", buttons=1, clickCount=1)
        self.mouse("mouseReleased", x, y, button="left", clickCount=1)

    def click(self, selector):
        self.wait(f"document.querySelector({json.dumps(selector)})", f"'{selector}' is there")
        left, top, width, height = self.box(selector)
        self.click_at(left + width / 2, top + height / 2)

    def drag(self, x, y, to_x, modifiers=0, steps=6):
        self.mouse("mouseMoved", x, y)
        self.mouse("mousePressed", x, y, modifiers, button="left", buttons=1, clickCount=1)
        for step in range(1, steps + 1):
            self.mouse("mouseMoved", x + (to_x - x) * step / steps, y, modifiers, button="left", buttons=1)
        self.mouse("mouseReleased", to_x, y, modifiers, button="left", clickCount=1)

    def wheel(self, x, y, size, modifiers=0):
        self.mouse("mouseWheel", x, y, modifiers, deltaX=0, deltaY=size)

    def key(self, key, modifiers=0):
        code = KEY_CODES.get(key, ord(key.upper()) if len(key) == 1 else 0)
        more = {"key": key, "windowsVirtualKeyCode": code, "modifiers": modifiers}
        text = {"Enter": "\r"}.get(key, key if len(key) == 1 and not modifiers & (ALT | CTRL) else None)
        self.browser.ask(
            "Input.dispatchKeyEvent", self.session, type="keyDown" if text else "rawKeyDown", **more, **({"text": text} if text else {})
        )
        self.browser.ask("Input.dispatchKeyEvent", self.session, type="keyUp", **more)

    def type(self, text):
        self.browser.ask("Input.insertText", self.session, text=text)

    def picture(self, path, **more):
        self.browser.screenshot(self.session, path, **more)

    def close(self):
        self.browser.ask("Target.closeTarget", targetId=self.target)
