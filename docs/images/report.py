"""Take the picture of a report's explorer that README and documentation show.

    snakemake --cores 2
    python docs/images/report.py results/demo/report.html docs/images/report.png

Needs Debian's chromium and chromium-driver, and the extra `test`.
"""

import base64
import io
import shutil
import sys
import tempfile
from pathlib import Path

from PIL import Image
from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.support.ui import WebDriverWait

WIDTH, HEIGHT, MARGIN = 1200, 900, 20
CYCLE = "3000"
FLAGS = ("--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--hide-scrollbars")
READY = "return document.documentElement.dataset.explorer === 'ready'"
COMPARE = """
document.getElementById("compare").click();
const slider = document.getElementById("cycle");
while (document.getElementById("cycle-shown").textContent !== arguments[0] && +slider.value > 0) {
  slider.stepDown();
  slider.dispatchEvent(new Event("input"));
}
const { x, y, width, height } = document.getElementById("explorer").getBoundingClientRect();
return [x + scrollX, y + scrollY, width, height];
"""


def picture(report: Path) -> Image.Image:
    """Open a report, superimpose a second case at one cycle, and return the picture."""
    with tempfile.TemporaryDirectory() as profile:
        options = Options()
        options.binary_location = str(shutil.which("chromium"))
        for flag in (*FLAGS, f"--user-data-dir={profile}"):
            options.add_argument(flag)
        driver = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
        try:
            driver.set_window_size(WIDTH, HEIGHT)
            driver.get(report.resolve().as_uri())
            WebDriverWait(driver, 60).until(lambda browser: browser.execute_script(READY))
            x, y, width, height = driver.execute_script(COMPARE, CYCLE)
            clip = {
                "x": x - MARGIN,
                "y": y,
                "width": width + 2 * MARGIN,
                "height": height + MARGIN,
                "scale": 1,
            }
            shot = driver.execute_cdp_cmd(
                "Page.captureScreenshot", {"clip": clip, "captureBeyondViewport": True}
            )
        finally:
            driver.quit()
    return Image.open(io.BytesIO(base64.b64decode(shot["data"])))


if __name__ == "__main__":
    source, target = map(Path, sys.argv[1:])
    picture(source).convert("RGB").quantize(256, dither=Image.Dither.NONE).save(
        target, optimize=True
    )
