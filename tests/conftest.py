"""How the property tests run everywhere: the same examples each time, however slow the machine."""

from hypothesis import settings

settings.register_profile("reproducible", deadline=None, derandomize=True)
settings.load_profile("reproducible")
