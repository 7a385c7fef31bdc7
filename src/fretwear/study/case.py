"""A case: all parameters of one simulation, validated, frozen, in SI units.

The id, the canonical parameters and the coordinates come from one walk over the declared fields, so
that none of them can miss a parameter.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Iterator, Mapping, Set
from dataclasses import MISSING, dataclass, replace
from functools import cached_property, lru_cache
from itertools import islice
from typing import Annotated, Any

from pydantic import TypeAdapter

from fretwear.mechanics.contact.grid import Grid
from fretwear.mechanics.slip.models import Auto, SlipModel
from fretwear.mechanics.surfaces.loading import Loading, SlidingDistance
from fretwear.mechanics.surfaces.setup import Setup
from fretwear.plugins import plugins
from fretwear.quantity import (
    AXES,
    Coordinates,
    Inline,
    MappingOf,
    Parameter,
    PartOf,
    Plain,
    Quantity,
    declared,
    derived,
    field_names,
    inlined,
    json_text,
)
from fretwear.study.cycles import CYCLES, Block, Blocks, Snapshots, snapshots_of
from fretwear.study.discretisation import (
    LARGEST_ROUNDING,
    LEAST_COARSENESS,
    LEAST_RATIO,
    RATIO_ON_GRID,
    STEPS_PER_ACCURACY,
    WIDEST,
    Discretisation,
    unworn_peak,
)
from fretwear.study.keys import Keys, coordinate
from fretwear.study.materials import MATERIAL
from fretwear.study.mistakes import Mistake, Mistakes
from fretwear.study.rules import findings
from fretwear.study.short_forms import long_form
from fretwear.units import in_unit

# Packages beside the core add kinds of parts.
for _kinds in plugins("fretwear.parts").values():
    _kinds.load()

_USUAL_SLIP = Auto()
_SNAPSHOTS = {"output_cycles": Snapshots}
_IN_BLOCKS = "normal", "loading", "friction_law"

Members = dict[str, Any]  # of a case, by name


class CaseError(ValueError):
    """Parameters that do not make a valid case; `mistakes` lists everything that is wrong."""

    def __init__(self, mistakes: Iterable[Mistake]) -> None:
        self.mistakes = tuple(mistakes)
        super().__init__(self.mistakes)

    def __str__(self) -> str:
        return "\n".join(str(mistake) for mistake in self.mistakes)


@dataclass(frozen=True, init=False, kw_only=True)
class Case(Setup):
    """One contact, one loading and one number of cycles, for `simulate`.

    Values are SI numbers or text with a unit (``load="50 N"``); attributes are SI floats. A case
    has the parameters of `base` in a study file, and ``output_cycles``, the cycles at which fields
    are kept besides 0 and the last; by default (``auto``) about eight.

    The model treats the bodies as equal, with the composite moduli E* and G* standing for both. It
    neglects the coupling of normal and tangential directions (Dundurs' β) of two different
    materials, and traction along y unless ``slip_model`` is ``coupled``. On rings slip is the mean
    over all directions: at ν = 0.3 the maximum wear depth is up to 16 % too small, unless
    ``slip_model`` is ``cerruti``, which takes a grid.

    Raises
    ------
    CaseError
        If names are unknown, values wrong or rules broken; the message lists all of them.

    Examples
    --------
    >>> case = Case(radius="10 mm", youngs_modulus="208 GPa", poisson_ratio=0.3, load="50 N",
    ...             tangential_ratio=0.8, friction=0.5, wear_coefficient="7e-13 / Pa", cycles=1000)
    >>> round(case.hertz_radius * 1e6, 1)
    148.6
    """

    cycles: Annotated[int, CYCLES, "Number of load cycles."]
    slip_model: Annotated[
        SlipModel,
        PartOf(SlipModel, "slip model", like="cerruti"),
        "Model of slip.",
    ] = _USUAL_SLIP
    cell: Annotated[
        tuple[float, float] | None,
        Quantity("m", "$Δ$", "grid spacing", "um", like="0.5 um", gt=0.0, places=AXES),
        "Grid spacing along x and y.",
    ] = None
    tolerance: Annotated[
        float,
        Quantity("1", "tolerance", "tolerance", like="0.01", gt=1e-6, le=0.1),
        "Relative error of the wear integration.",
    ] = 0.01
    blocks: Annotated[
        tuple[Block, ...],
        Blocks(
            "blocks",
            "blocks of loading",
            "[{cycles: 2000, tangential_ratio: 0.5}, {cycles: 5000, tangential_ratio: 0.9}]",
        ),
        "Successive blocks of cycles, each with what changes: load, displacement or force, "
        "friction.",
    ] = ()
    error_estimate: Annotated[
        bool,
        Plain("", "estimate of errors", "false"),
        "Whether a run on wider cells estimates errors.",
    ] = True
    accuracy: Annotated[
        float,
        Quantity(
            "1",
            "accuracy",
            "accuracy",
            like="0.02",
            ge=0.001,
            le=0.2,
            infinite="as on default cells",
        ),
        "Largest relative error of key results; none: default cells.",
    ] = 0.02
    budget: Annotated[
        float | None,
        Quantity("1", "budget", "budget", like="10", ge=1.0, le=1000.0),
        "Largest work over that on default cells; 10 by default.",
    ] = None
    output_cycles: tuple[int, ...] = ()

    def __init__(self, members: Members | None = None, /, **parameters: object) -> None:
        """Take parameters, or members already read, which are not checked against each other."""
        broken: list[Mistake] | None = None
        if members is None:
            members, unread, broken = _read(parameters)
        elif not members.keys() <= field_names(Case):
            raise TypeError("parameters are keywords: fretwear.Case(**parameters)")
        values = {**members}
        # Fields of open parts are attributes too, unless all parts have a property of that name.
        for name, parameter in case_members().items():
            part: Any = members.get(name)
            if is_open(parameter, part):
                fields = (field for field in part.parameters() if not hasattr(Case, field))
                values |= {field: vars(part)[field] for field in fields}
        for name, value in values.items():
            object.__setattr__(self, name, value)
        if broken is not None and (broken := [*broken, *self.mistakes(unread)]):
            raise CaseError(broken)

    def mistakes(self, unread: Set[str] = frozenset()) -> list[Mistake]:
        """The broken rules; rules that read an unread member are not tried."""
        has_blocks = self.blocks and not unread & {"blocks", "cycles", *_IN_BLOCKS}
        blocks = [block for _, block in self.in_blocks()] if has_blocks else []
        return findings(self, unread, blocks)

    def __repr__(self) -> str:
        rows = {
            parameter.words: parameter.text(in_unit(value, parameter.si_unit))
            for _, value, parameter in self._declared_coordinates()
        }
        width = max(map(len, rows))
        lines = (f"  {words:<{width}}  {value}" for words, value in rows.items())
        return "\n".join([f"<Case {self.case_id}>", *lines])

    def changed(self, **members: object) -> Case:
        """The case with other members, not checked against each other."""
        own = {name: vars(self)[name] for name in field_names(Case) if name in vars(self)}
        return Case({**own, **members})

    def replace(self, **changes: object) -> Case:
        """Return the case with other values of some parameters: ``case.replace(load="60 N")``."""
        kept: dict[str, object] = {}
        for member, parameter in case_members().items():
            value = getattr(self, member)
            open_ = is_open(parameter, value)
            kept |= {n: vars(value)[n] for n in value.parameters()} if open_ else {member: value}
        # Blocks contain their cycles.
        del kept["cycles" if self.blocks else "blocks"]
        for replaced in set[str]().union(*map(case_keys().replaced_by, changes)):
            kept.pop(replaced, None)
        if not changes.get("error_estimate", True) or changes.get("cell"):
            kept.pop("accuracy", None)
        if self.output_cycles != snapshots_of(None, self.cycles):
            # The last cycle may change.
            kept["output_cycles"] = self.output_cycles[:-1]
        return Case(**{**kept, **changes})

    # The cells.

    @cached_property
    def cells(self) -> Discretisation:
        """The cells that suit it."""
        return Discretisation(self, self.slip_model, self.cycles, self.force_is_held)

    @cached_property
    def grid_spacing(self) -> tuple[float, float]:
        """(dx, dy) in m: `cell` or, if it is None, the default of its `cells`."""
        return self.cell or self.cells.default_spacing

    @cached_property
    def coarseness(self) -> float:
        """Width of graded rings or strips over the usual one: 1, or less with a finer `cell`."""
        if self.cell is None or not self.cells.is_graded:
            return 1.0
        (dx, dy), (usual_x, usual_y) = self.cell, self.cells.usual_spacing
        ratio = min(dx / usual_x, dy / usual_y)
        # The default spacing is rounded down, so writing it changes nothing.
        return 1.0 if LARGEST_ROUNDING * ratio > 1.0 - 1e-9 else max(LEAST_COARSENESS, ratio)

    @property
    def width_at_edges(self) -> float:
        """Width of the cells where contact and stick zone end, m."""
        if self.cells.is_graded:
            return self.coarseness * self.cells.narrowest_cell
        return math.sqrt(math.prod(self.grid_spacing))

    @cached_property
    def asked_accuracy(self) -> float | None:
        """The accuracy from which the cells are chosen; None if the cells are given."""
        return self.accuracy if self.cell is None and math.isfinite(self.accuracy) else None

    @property
    def has_equal_cells(self) -> bool:
        """Whether the contact is computed on equal cells, at one place."""
        return self.cells.geometry is Grid and not self.loading.stroke

    @property
    def first_width(self) -> float:
        """Width of the first cells over the default if an accuracy is requested."""
        return RATIO_ON_GRID if self.has_equal_cells else WIDEST

    @property
    def times_coarser(self) -> float:
        """Width ratio of the cells of the coarser run from which errors are estimated.

        Details to be resolved and scars of a stroke allow cells only twice as wide. Cells that an
        accuracy has made wide allow `LEAST_RATIO`, and equal cells `RATIO_ON_GRID`.
        """
        if self.has_equal_cells:
            return RATIO_ON_GRID
        if self.asked_accuracy is not None:
            return LEAST_RATIO
        plain = all(math.isinf(min(part.finest)) for part in self.surfaces.values())
        return 3.0 if plain and not self.loading.stroke else 2.0

    def tolerance_on(self, times: float) -> float:
        """The tolerance on cells some times wider: larger by the square.

        On a grid steps err far less than cells. With a requested accuracy they get a small part of
        it at 1.5 times the accuracy, or the tolerance of cells twice as wide, beyond which steps
        get no cheaper. A tolerance written beside an accuracy does not change.
        """
        wider = times**2 * self.tolerance
        if self.asked_accuracy is None:
            return wider
        if self.tolerance != Case.tolerance:
            return self.tolerance
        if self.cells.geometry is not Grid or self.loading.stroke:
            return wider
        enough = min(STEPS_PER_ACCURACY * self.asked_accuracy, WIDEST**2 * self.tolerance)
        return max(wider, enough)

    def times_written(self, times: float) -> float:
        """Width ratio of the cells on which a run on cells some times wider is written.

        With a requested accuracy, rings and strips are written on the default cells or finer ones.
        """
        is_apart = self.cells.is_graded and self.asked_accuracy is not None
        return min(times, 1.0) if is_apart else times

    def on_cells(self, times: float) -> Case:
        """The case on cells some times wider, with their tolerance."""
        tolerance = self.tolerance_on(times)
        if times == 1.0 and tolerance == self.tolerance:
            return self
        dx, dy = self.grid_spacing
        wider = self.times_written(times)
        return self.changed(cell=(wider * dx, wider * dy), tolerance=tolerance)

    @cached_property
    def plain_loading(self) -> Loading:
        """The loading along x in SI units, in whichever form it was given."""
        if self.blocks or (self.loading.is_force and not self.force_is_held):
            return self.loading
        return self.loading.plain(*self._unworn)

    @cached_property
    def force_is_held(self) -> bool:
        """Whether P and Q, and so Q/(µP), are constant."""
        constant = self.at(self.cycles) is self and not self.blocks
        return constant and self.normal.holds_load and self.loading.is_force

    # The coating.

    @property
    def coating_ratio(
        self,
    ) -> Annotated[
        float, Quantity("1", r"$h_\mathrm{c}/a$", "thickness of the coating over contact radius")
    ]:
        """h/a, with the contact radius of the uncoated bodies; NaN without a coating."""
        return math.nan if self.coating is None else self.coating.thickness / self.hertz_radius

    @property
    def coating_pressure_ratio(
        self,
    ) -> Annotated[
        float, Quantity("1", r"$p_\mathrm{c}/p_0$", "peak pressure over that of uncoated bodies")
    ]:
        """Peak pressure of the unworn smooth bodies, over that without the coating; NaN if none."""
        if self.film is None:
            return math.nan
        return unworn_peak(self, self.film) / unworn_peak(self, None)

    # Blocks of loading.

    def in_blocks(self) -> Iterator[tuple[float, Case | None]]:
        """Each block as a case (None if it is not valid), with the cycle at which it ends."""
        end = 0
        for block in self.blocks or (Block(cycles=self.cycles),):
            end += block.cycles
            changed: dict[str, object] = {"blocks": ()}
            for member in _IN_BLOCKS:
                parameter = case_members()[member]
                assert isinstance(parameter, Inline)
                keys = parameter.keys
                if changes := {name: value for name, value in block.values.items() if name in keys}:
                    changed[member] = parameter.changed(getattr(self, member), changes)
            yield end, None if None in changed.values() else self.changed(**changed)

    # What identifies a case.

    def canonical_parameters(self) -> dict[str, object]:
        """Return every parameter but the snapshots, in SI units, in a form that JSON can hold.

        Two cases with the same physics have the same canonical parameters. These have no units, one
        form for Q/(µP) and Q, one value for a pair of equal values, a smooth surface for a zero
        amplitude, and the value of the default spacing unless an accuracy is requested.
        `Case(**...)` takes them back.
        """
        canonical: dict[str, object] = {}
        for name, value in self._identifying_members().items():
            parameter = case_members()[name]
            if is_open(parameter, value):
                canonical |= value.canonical()
            elif value is not None and value != ():
                canonical[name] = parameter.canonical(value)
        canonical.pop("kind", None)
        return canonical

    def _identifying_members(self) -> Members:
        """The members in the one form that all cases of the same physics share."""
        values: Members = {name: getattr(self, name) for name in case_members()}
        values |= {"loading": self.plain_loading, "cell": None}
        if self.asked_accuracy is None:
            values["cell"] = self.grid_spacing
            if math.isinf(self.accuracy):
                del values["accuracy"]  # a written cell alone asks for none
        if self.blocks:
            del values["cycles"]  # they contain it
        return values

    @cached_property
    def case_id(self) -> str:
        """``<slug>-<hash>``: the main parameters, then eight digits of a hash of all parameters.

        Parameters at their defaults do not count, so a new parameter with a default changes no id.
        Numbers count to twelve digits. The characters are letters, digits, ``.``, ``-`` and ``_``,
        safe in paths and shells.
        """
        members_ = self._identifying_members().items()
        at_default = {name for name, value in members_ if value == getattr(Case, name, MISSING)}
        parameters = self.canonical_parameters()
        text = json_text({n: one for n, one in parameters.items() if n not in at_default})
        capped = math.isfinite(self.plastic_limit)
        parts = (
            self.indenter.slug,
            self.normal.slug_in(self.frame),
            self.plain_loading.slug_in(self.frame),
            self.friction_law.slug,
            "smooth" if self.roughness is None else self.roughness.slug,
            "" if self.counterface is None else self.counterface.slug,
            f"Y{self.plastic_limit * 1e-6:.4g}MPa" if capped else "elastic",
            f"N{self.cycles}",
            hashlib.sha256(text.encode()).hexdigest()[:8],
        )
        return "-".join(part for part in parts if part).replace("+", "")

    def scalar_coordinates(self) -> dict[str, tuple[float | str, str, str]]:
        """Return the scalar coordinates of a dataset: SI value, UDUNITS unit, long name by name.

        An elastic case has a `plastic_limit` of inf, a smooth one zero amplitude and slopes.
        Materials that differ appear as ``youngs_modulus_1``, ``youngs_modulus_2``.
        """
        return {
            coordinate(name): (value, "" if isinstance(value, str) else key.si_unit, key.words)
            for name, value, key in self._declared_coordinates()
        }

    def _declared_coordinates(self) -> Iterator[tuple[str, float | str, Parameter]]:
        keys, following = case_keys(), derived(Case)
        for name, value in self._coordinates():
            parameter = keys.coordinate(name).in_frame(self.frame)
            if name in following:
                parameter = parameter.renamed(parameter.words.replace("radius", self.frame.extent))
            yield name, value, parameter

    def _coordinates(self) -> Coordinates:
        following = dict(derived(Case))
        if self.coating is None:
            del following["coating_ratio"], following["coating_pressure_ratio"]
        # Values for members whose default depends on the contact.
        solved = {"cell": self.grid_spacing, "slip_model": self.cells.solved_slip_model}
        # These are results if the other quantity of the loading is given.
        if not self.force_is_held:
            del following["tangential_ratio"], following["tangential_load"]
        if self.loading.is_force or self.loading.stroke:
            del following["displacement_amplitude"], following["displacement_ratio"]
        for member, parameter in case_members().items():
            value: Any = solved.get(member, getattr(self, member))
            if isinstance(parameter, Inline):
                for name, one in {**parameter.keys, **value.parameters()}.items():
                    if name in following or name in vars(value):
                        following.pop(name, None)
                        yield from one.coordinates(name, getattr(self, name))
            elif member == "cell":
                yield from islice(parameter.coordinates(member, value), len(self.frame.axes))
            elif value is not None or (isinstance(parameter, PartOf) and not parameter.is_second):
                yield from parameter.coordinates(member, value)
        for name, quantity in following.items():
            # Only Hertzian contacts have quantities named after Hertz.
            if self.indenter.is_hertzian or not name.startswith("hertz"):
                yield from quantity.coordinates(name, getattr(self, name))


@lru_cache(2)
def _form(keys: Keys) -> TypeAdapter[Members]:
    """The pydantic form that reads the keywords of a case."""
    return TypeAdapter(Annotated[Members, MappingOf({**keys.types, **_SNAPSHOTS})])


def _read(parameters: Mapping[str, object]) -> tuple[Members, Set[str], Mistakes]:
    """Read the keywords of a case; returns what `assembled` does."""
    mistakes, keys = Mistakes(), case_keys()
    keywords = {name: value for name, value in parameters.items() if value is not None}
    keywords = long_form(keywords, {})
    form = _form(keys)
    values = mistakes.read(form, keywords, lambda: inlined(form.json_schema()))
    snapshots = values.pop("output_cycles", None)
    values.pop(MATERIAL, None)
    unread = keys.unread(keywords.keys() - {"output_cycles"}, values.keys())
    members, lacking, found = assembled(values, unread, snapshots)
    mistakes += found
    return members, lacking, mistakes


def assembled(
    values: Mapping[str, object], unread: Set[str], snapshots: tuple[int, ...] | None
) -> tuple[Members, Set[str], Mistakes]:
    """Return the members of a case by the values of keys, the unread members, and the mistakes.

    The mistakes are missing or superfluous keys. The number of cycles follows from the blocks, and
    the snapshots from both.
    """
    mistakes, keys = Mistakes(), case_keys()
    members: Members = {**keys.members_of(values, unread, mistakes), "output_cycles": snapshots}
    if blocks := members.get("blocks"):
        members["cycles"] = sum(block.cycles for block in blocks)
    if members.get("cell") is not None or not members.get("error_estimate", True):
        members.setdefault("accuracy", math.inf)
    if cycles := members.get("cycles"):
        if isinstance(loading := members.get("loading"), SlidingDistance):
            members["loading"] = replace(loading, parts=cycles)
        members["output_cycles"] = snapshots_of(snapshots, cycles)
    return members, keys.lacking(members, unread), mistakes


def case_members() -> Mapping[str, Parameter]:
    """Return the fields of a case, except the snapshots, with their declarations."""
    return declared(Case)


def case_keys() -> Keys:
    """Return the keys of a case with the present kinds of parts."""
    families = (part.family for part in case_members().values() if isinstance(part, PartOf))
    return _keys(tuple(tuple(family.kinds().items()) for family in families))


@lru_cache(2)
def _keys(_: tuple[tuple[tuple[str, type], ...], ...]) -> Keys:
    return Keys(Case)


def is_open(parameter: Parameter, value: object) -> bool:
    """Whether the fields of a part are keys of the case."""
    if isinstance(parameter, Inline):
        return value is not None
    return isinstance(parameter, PartOf) and getattr(value, "kind", "") == parameter.short != ""
