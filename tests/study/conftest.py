from pathlib import Path

import pytest

from fretwear.study.problems import StudyError
from fretwear.study.study import Study, load_study

from ..studies import two_loads, write_study


@pytest.fixture
def content():
    return two_loads(output={"cycles": [0, 100]})


class StudyFolder:
    """Writes study files and loads them."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def write(self, content, name="study.yaml") -> Path:
        return write_study(self.folder / name, content)

    def load(self, content, assignments=()) -> Study:
        return load_study(self.write(content), assignments)

    def error(self, content, assignments=()) -> StudyError:
        with pytest.raises(StudyError) as caught:
            self.load(content, assignments)
        return caught.value


@pytest.fixture
def studies(tmp_path):
    return StudyFolder(tmp_path)
