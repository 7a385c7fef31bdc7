"""The form of a study file: its sections, their types, and the JSON Schema that follows."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, TypeAdapter, create_model

from fretwear.arrays import Array
from fretwear.plugins import plugins
from fretwear.quantity import AUTO, MappingOf, PartOf, Schema, auto_or, inlined
from fretwear.study.case import Case, case_keys
from fretwear.study.cycles import Snapshots
from fretwear.study.designs import MAX_POINTS, Combinations, Design
from fretwear.study.keys import Keys, varied_type
from fretwear.study.mistakes import Mistakes
from fretwear.variable import Variable

MAX_TITLE = 200
_Text = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)]


class Output(BaseModel):
    """Snapshots, stresses and lives to write."""

    model_config = ConfigDict(extra="forbid")

    cycles: Snapshots = None


class Sections(BaseModel):
    """The sections of a study file."""

    model_config = ConfigDict(extra="forbid")

    title: Annotated[
        str,
        StringConstraints(strip_whitespace=True, min_length=1, max_length=MAX_TITLE),
        Field(description="Title for readers."),
    ] = ""
    base: Annotated[
        dict[str, object], Field(description="One value for every parameter that is not varied.")
    ] = {}
    vary: Annotated[
        dict[str, object], Field(description="The varied parameters, each with its values.")
    ] = {}
    design: Annotated[
        Design, PartOf(Design, "design", like="grid", description="How varied values combine.")
    ] = Combinations()
    invalid: Annotated[
        Literal["stop", "skip"], Field(description="What to do about points such as Q >= µP.")
    ] = "stop"
    batch: Annotated[
        int | None,
        Field(ge=1, le=MAX_POINTS, description="Cases of a job."),
        AUTO,
        auto_or({"type": "integer", "minimum": 1}),
        Field(json_schema_extra={"default": "auto"}),
    ] = None
    output: Output = Output()
    creator: Annotated[_Text, Field(description="Author of the study, for its datasets.")] = ""
    license: Annotated[_Text, Field(description="License of the results.")] = ""
    institution: Annotated[_Text, Field(description="Institution of the author.")] = ""
    references: Annotated[_Text, Field(description="Publications about the study.")] = ""


class StudySection:
    """A section of a study file: a pydantic dataclass of a package beside the core."""

    cycles: tuple[int, ...] | None = None
    """Snapshots that the section needs, which every case then keeps."""

    @property
    def files(self) -> Sequence[Path]:
        """Files that the section names."""
        return ()

    @property
    def file_summaries(self) -> Sequence[str]:
        """Descriptions of these files, for people."""
        return ()

    @classmethod
    def complete_base(
        cls,
        section: object,
        base: Mapping[str, object],
        vary: Mapping[str, object],
        mistakes: Mistakes,
    ) -> Mapping[str, object]:
        """The plain keys of `base`, with those that this section makes superfluous."""
        return base

    def check(self, cases: Sequence[Case | None], mistakes: Mistakes) -> None:
        """Check the section against the cases of all points, and add its mistakes."""

    def seconds(self, case: Case, cells: float) -> float:
        """Processor time, s, that the section adds to a case with so many cells."""
        return 0.0

    def after_case(self, case: Path) -> None:
        """Compute the results that the section adds to a case that has just finished."""

    def extra_results(
        self, case: Path, cycles: Array, tell: Callable[[str], None]
    ) -> Mapping[Variable, Array]:
        """Further results of a case file over cycles, for the merged study."""
        return {}


def study_sections() -> Iterator[tuple[str, type[StudySection]]]:
    """The sections of study files that packages beside the core define, with their places."""
    for place, entry in plugins("fretwear.study_sections").items():
        yield place, entry.load()


def study_form(varied: Iterable[str]) -> TypeAdapter[Sections]:
    """Return the form that reads a study file with some varied parameters.

    It knows the keys of cases and of packages besides the core.
    """
    keys = case_keys()
    return _form(keys, tuple(name for name in varied if name in keys.all_names))


@lru_cache(8)
def _form(keys: Keys, varied: tuple[str, ...]) -> TypeAdapter[Sections]:
    added: dict[str, dict[str, Any]] = {"": {}, "output": {}}
    for place, section in study_sections():
        whole, _, key = place.rpartition(".")
        added[whole][key] = section, None
    output = create_model("Output", __base__=Output, __doc__=Output.__doc__, **added["output"])
    base, vary = (
        Annotated[dict[str, object], MappingOf(types), Field(description=field.description)]
        for types, field in (
            (keys.types, Sections.model_fields["base"]),
            ({name: varied_type(keys[name]) for name in varied}, Sections.model_fields["vary"]),
        )
    )
    own: dict[str, Any] = {"base": (base, {}), "vary": (vary, {}), "output": (output, output())}
    return TypeAdapter(create_model("Sections", __base__=Sections, **own, **added[""]))


def study_schema() -> Schema:
    """Return the JSON Schema (2020-12) of a study file, made from the models that read it.

    It covers names, kinds of values and their descriptions. Only `load_study` checks rules on
    several values at once (Q < µP, a cell fine enough for the roughness, equal lengths under
    ``zip``).
    """
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **inlined(study_form(case_keys().all_names).json_schema()),
        "title": "fretwear study",
        "description": "A study of fretting wear: base values, varied values, output.",
    }
