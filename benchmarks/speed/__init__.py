"""How fast the simulator is, in units that do not depend on the machine.

One CE is the time of one bare convolution by scipy.fft (cosine transform of the rows that are not
zero, of all columns, multiplication, inverse) on the same quarter window with the same number of
threads, measured in the same process, in turn with what is measured.
"""
