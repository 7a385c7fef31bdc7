"""Normal contact on cells: problem, solver, convolution, grid, rings, strips."""
