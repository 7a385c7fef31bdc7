"""A headless Chromium that opens a report from disk, and what the tests ask of it."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import Select, WebDriverWait

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
MISSING = "" if CHROMIUM and DRIVER else "Debian's chromium and chromium-driver are not installed"

_FLAGS = "--headless=new --no-sandbox --no-first-run --disable-gpu --disable-dev-shm-usage"
_FLAGS += " --disable-quic --disable-sync --disable-component-update"
_FLAGS += " --disable-background-networking"
_PATIENCE = 60
DESKTOP = (1280, 900)

# Contrast of every visible text with what is painted behind it, as WCAG 2 computes it.
CONTRASTS = """
const channel = (v) => (v /= 255, v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
const light = (c) => 0.2126 * channel(c[0]) + 0.7152 * channel(c[1]) + 0.0722 * channel(c[2]);
const parse = (text) => (text.match(/[\\d.]+/g) || [0, 0, 0, 0]).map(Number);
function behind(element) {
  for (let at = element; at; at = at.parentElement) {
    const color = parse(getComputedStyle(at).backgroundColor);
    if (color.length < 4 || color[3] > 0) return color;
  }
  return [255, 255, 255];
}
const found = [];
const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
for (let node = walker.nextNode(); node; node = walker.nextNode()) {
  const element = node.parentElement;
  if (!node.textContent.trim() || element.closest("script, style, option")) continue;
  if (!element.checkVisibility({ visibilityProperty: true })) continue;
  const style = getComputedStyle(element);
  const ink = parse(element.closest("svg") ? style.fill : style.color);
  const [high, low] = [light(ink), light(behind(element))].sort((a, b) => b - a);
  const large = parseFloat(style.fontSize) >= 24;
  const ratio = (high + 0.05) / (low + 0.05);
  if (ratio < (large ? 3 : 4.5)) found.push([ratio, node.textContent.trim().slice(0, 40)]);
}
return found;
"""


class Browser:
    """A browser with one page."""

    def __init__(self, profile: Path) -> None:
        options = Options()
        options.binary_location = str(CHROMIUM)
        for flag in (*_FLAGS.split(), f"--user-data-dir={profile}"):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=Service(str(DRIVER)))

    def close(self) -> None:
        self.driver.quit()

    def open(
        self, file: Path, *, size: tuple[int, int] = DESKTOP, media: str = "", **features: str
    ) -> None:
        """Open a page afresh at a size of the window, with media features such as dark mode."""
        self.resize(size)
        named = [{"name": n.replace("_", "-"), "value": value} for n, value in features.items()]
        self.driver.execute_cdp_cmd(
            "Emulation.setEmulatedMedia", {"media": media, "features": named}
        )
        self.errors()
        self.requests()
        self.driver.get(file.as_uri())
        self.wait("return document.documentElement.dataset.explorer === 'ready'")

    def resize(self, size: tuple[int, int]) -> None:
        width, height = size
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)

    def ask(self, script: str, *arguments: object) -> Any:
        return self.driver.execute_script(script, *arguments)

    def violations(self, axe: str) -> list[tuple[str, str]]:
        """Rules of accessibility that the page breaks, WCAG 2 to level AA, and where."""
        # The page refuses foreign scripts; the debugger evaluates this one beside them.
        asked = f"{axe};axe.run().then((found) => found.violations.flatMap((one) => "
        asked += "one.nodes.map((node) => [one.id, node.html.slice(0, 120)])))"
        script = {"expression": asked, "awaitPromise": True, "returnByValue": True}
        found = self.driver.execute_cdp_cmd("Runtime.evaluate", script)["result"]
        return [(rule, place) for rule, place in found["value"]]

    def wait(self, script: str) -> None:
        WebDriverWait(self.driver, _PATIENCE, 0.05).until(lambda _: self.ask(script))

    def find(self, selector: str) -> Any:
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def texts(self, selector: str) -> list[str]:
        script = (
            "return [...document.querySelectorAll(arguments[0])]"
            ".filter((element) => element.checkVisibility())"
            ".map((element) => element.textContent.trim())"
        )
        return list(self.ask(script, selector))

    def press(self, *keys: str) -> None:
        ActionChains(self.driver).send_keys(*keys).perform()

    def choose(self, key: str, **labels: str) -> None:
        """Choose a case in the explorer by the texts of its controls."""
        for label in self.driver.find_elements(By.CSS_SELECTOR, f"#case-{key} .choices label"):
            words = label.text.split("\n")[0].replace(" ", "_")
            if words in labels:
                Select(label.find_element(By.TAG_NAME, "select")).select_by_visible_text(
                    labels[words]
                )

    def move(self, place: int) -> None:
        script = (
            "const slider = document.getElementById('cycle'); slider.value = arguments[0];"
            "slider.dispatchEvent(new Event('input'))"
        )
        self.ask(script, place)

    def curve(self, name: str, plot: str = "profile-plot", along: str = "y") -> np.ndarray:
        """Return the heights of a curve, or where they are, as plotly has them."""
        script = (
            "return document.getElementById(arguments[0])._fullData"
            ".find((trace) => trace.name === arguments[1])?.[arguments[2]]"
        )
        values = self.ask(script, plot, name, along)
        assert values is not None, f"there is no curve {name}"
        return np.array(values, dtype=float)

    def curves(self, plot: str = "profile-plot") -> set[str]:
        """Return the names of what a plot shows."""
        script = "return (document.getElementById(arguments[0])._fullData || []).map((t) => t.name)"
        return set(self.ask(script, plot)) if self.find(f"#{plot}").is_displayed() else set()

    def errors(self) -> list[str]:
        return [entry["message"] for entry in self.driver.get_log("browser")]

    def requests(self) -> list[str]:
        """Return the addresses asked for since the last call, those inside the page left out."""
        messages = [json.loads(e["message"])["message"] for e in self.driver.get_log("performance")]
        sent = [m["params"] for m in messages if m["method"] == "Network.requestWillBeSent"]
        addresses = [params["request"]["url"] for params in sent]
        # The browser's own first page is made of chrome: addresses, which are inside of it.
        return [one for one in addresses if not one.startswith(("data:", "chrome:"))]
