"""Changes to the content of a study file: options of the command line, and values of a point."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping

from fretwear.problems import Problems
from fretwear.study.materials import MATERIAL
from fretwear.study.parameters import parameter_names, replaced_by
from fretwear.study.sections import SEEDS
from fretwear.study.yamlfile import as_mapping, parse_value
from fretwear.units import QuantityError

OPTION = "--set"


def override(
    raw: Mapping[str, object], assignments: Iterable[str]
) -> tuple[dict[str, object], Problems]:
    """Return plain content changed by assignments ``name=value``, and problems of the assignments.

    The new value replaces the value in `base`, and the parameter is no longer varied. Setting one
    of several alternative keys, such as the two tangential ones, drops the others; keys that belong
    to both, such as `rig_stiffness`, stay. ``output.cycles`` and ``title`` can be set too.
    """
    changed, problems = copy.deepcopy(dict(raw)), Problems()
    valid = (*parameter_names(), MATERIAL, "output.cycles", "title")
    for assignment in assignments:
        name, equals, text = assignment.partition("=")
        name = name.strip()
        place = f"{OPTION} {name}"
        if not equals:
            rule = "must have the form name=value"
            problems.add(OPTION, assignment, rule, "such as --set 'load=30 N'")
        elif name not in valid:
            problems.add(place, text, "is not a parameter", valid_words=valid, written=name)
        else:
            with problems.at(place, text):
                value = parse_value(text)
                with problems.at(place, value):
                    assign(changed, name, value)
    return changed, problems


def assign(content: dict[str, object], name: str, value: object) -> None:
    """Give a parameter one value in the plain content of a study file, as for `override`."""
    if name in ("title", "output.cycles"):
        section, _, key = name.partition(".")
        content[section] = {key: value} if key else value
        return
    base, vary = (as_mapping(content.get(section)) for section in ("base", "vary"))
    gone = replaced_by(name)
    base = {key: given for key, given in base.items() if key not in gone}
    replaced = tuple(f"{key}." for key in (*gone, name))
    vary = {key: given for key, given in vary.items() if not f"{key}.".startswith(replaced)}
    content |= {"base": base, "vary": vary}
    if SEEDS in (name, f"{name}.seed"):
        content.pop("seeds", None)
    whole, _, part = name.partition(".")
    if part and whole in vary:
        raise QuantityError(f"cannot be set while vary.{whole} varies the whole of it")
    base[whole] = {**as_mapping(base.get(whole)), part: value} if part else value
    if not vary:
        del content["vary"]
        if "seeds" not in content:
            # A sampled design with nothing to sample would be an error.
            content.pop("design", None)
