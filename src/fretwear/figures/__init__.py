"""One function per figure: a dataset in, a matplotlib Figure out."""
