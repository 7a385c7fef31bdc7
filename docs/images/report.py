"""Take the picture of a report's beginning that README and documentation show.

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

WIDTH, HEIGHT, MARGIN = 1400, 900, 16
FLAGS = ("--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--hide-scrollbars")
READY = "return document.querySelector('#curve .main-svg') !== null"
END = "return document.querySelector('.answer').getBoundingClientRect().bottom"


def picture(report: Path) -> Image.Image:
    """Open a report and return its beginning, down to the end of its matrix."""
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
            part = {
                "x": 0,
                "y": 0,
                "width": WIDTH,
                "height": driver.execute_script(END),
                "scale": 1,
            }
            asked = {"clip": part, "captureBeyondViewport": True}
            shot = driver.execute_cdp_cmd("Page.captureScreenshot", asked)
        finally:
            driver.quit()
    return Image.open(io.BytesIO(base64.b64decode(shot["data"])))


if __name__ == "__main__":
    source, target = map(Path, sys.argv[1:])
    picture(source).convert("RGB").quantize(256, dither=Image.Dither.NONE).save(
        target, optimize=True
    )
