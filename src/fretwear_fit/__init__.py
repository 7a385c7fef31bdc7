"""Parameters of a case from measured scars: best values, intervals, and what the data leave open.

A measurement is compared with the results of runs; noise, base line and the numerical error of the
program enter its likelihood. The parameters are sought by Gauss–Newton steps on their logarithms,
and their intervals follow from the profile likelihood.
"""
