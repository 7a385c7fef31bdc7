"""The page docs/performance.md: everything that is measured of the simulator's speed."""
