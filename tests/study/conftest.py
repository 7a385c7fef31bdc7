import json

import pytest

from fretwear.study.problems import StudyError
from fretwear.study.reading import load_study
from fretwear.study.sections import study_schema

from ..studies import two_loads, write_study


@pytest.fixture(scope="session")
def validator():
    jsonschema = pytest.importorskip("jsonschema")
    schema = study_schema()
    assert json.loads(json.dumps(schema, allow_nan=False)) == schema
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


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
