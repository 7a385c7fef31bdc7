from pathlib import Path

import pytest
import yaml

from fretwear.study.problems import StudyError
from fretwear.study.study import Study, load_study


def sound_content():
    """The content of a small sound study, as plain values."""
    return {
        "title": "Two loads",
        "base": {
            "radius": "10 mm",
            "youngs_modulus": "208 GPa",
            "poisson_ratio": 0.3,
            "load": "50 N",
            "tangential_ratio": 0.8,
            "friction": 0.5,
            "wear_coefficient": "7e-13 / Pa",
            "plastic_limit": "none",
            "roughness": "none",
            "cycles": 1000,
        },
        "vary": {"load": ["25 N", "50 N"]},
        "output": {"cycles": [0, 100]},
    }


@pytest.fixture
def content():
    return sound_content()


class StudyFolder:
    """Writes study files and loads them."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def write(self, content, name="study.yaml") -> Path:
        file = self.folder / name
        text = content if isinstance(content, str) else yaml.safe_dump(content, sort_keys=False)
        file.write_text(text, encoding="utf-8")
        return file

    def load(self, content, assignments=()) -> Study:
        return load_study(self.write(content), assignments)

    def error(self, content, assignments=()) -> StudyError:
        with pytest.raises(StudyError) as caught:
            self.load(content, assignments)
        return caught.value


@pytest.fixture
def studies(tmp_path):
    return StudyFolder(tmp_path)
