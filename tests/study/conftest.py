import pytest

from fretwear.study.mistakes import StudyError
from fretwear.study.reading import load_study

from ..studies import two_loads, write_study


@pytest.fixture
def content():
    return two_loads(output={"cycles": [0, 100]})


class StudyFolder:
    def __init__(self, folder):
        self.folder = folder

    def write(self, content, name="study.yaml"):
        return write_study(self.folder / name, content)

    def load(self, content, assignments=()):
        return load_study(self.write(content), assignments)

    def error(self, content, assignments=()):
        with pytest.raises(StudyError) as caught:
            self.load(content, assignments)
        return caught.value


@pytest.fixture
def studies(tmp_path):
    return StudyFolder(tmp_path)
